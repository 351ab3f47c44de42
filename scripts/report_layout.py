"""What must hold of the layout of a page at any width: no label overlaps another or is cut, no word is broken; and what axe-core finds.

`complaints` and `violations` return lists of words, empty where all is well.
"""

from importlib.resources import files

# Boxes may overlap or stick out by so much (px): rounding, and the empty part of a line's height.
SLACK = 1.5
COMPLAINTS = """(slack) => {
  const found = [], words = (node) => (node.textContent ?? '').trim().slice(0, 40);
  const seen = (node) => node.checkVisibility?.() ?? true;
  const box = (node) => {
    if (node instanceof SVGElement) return node.getBoundingClientRect();
    const texts = document.createTreeWalker(node, NodeFilter.SHOW_TEXT), range = document.createRange(), rects = [];
    for (let text = texts.nextNode(); text; text = texts.nextNode()) {
      range.selectNodeContents(text);
      if (seen(text.parentElement)) rects.push(...range.getClientRects());
    }
    const [left, top] = ['left', 'top'].map((side) => Math.min(...rects.map((rect) => rect[side])));
    const [right, bottom] = ['right', 'bottom'].map((side) => Math.max(...rects.map((rect) => rect[side])));
    return { left, top, right, bottom, width: right - left };
  };
  const labels = (host, selector) => [...host.querySelectorAll(selector)].filter((node) => seen(node) && words(node)).map((node) => ({ node, at: box(node) })).filter(({ at }) => at.width > 0);
  const overlap = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > slack && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > slack;
  const inside = (a, b) => a.left >= b.left - slack && a.right <= b.right + slack && a.top >= b.top - slack && a.bottom <= b.bottom + slack;
  const apart = (all, what) => all.forEach((one, i) => all.slice(i + 1).forEach((other) => {
    if (overlap(one.at, other.at)) found.push(`${what}: "${words(one.node)}" overlaps "${words(other.node)}"`);
  }));
  for (const host of document.querySelectorAll('.chart')) {
    if (!seen(host)) continue;
    const each = labels(host, 'svg text'), frame = host.getBoundingClientRect();
    apart(each, host.id);
    for (const { node, at } of each) if (!inside(at, frame)) found.push(`${host.id}: "${words(node)}" is cut`);
  }
  apart(labels(document, '#arm .label'), 'arm');
  for (const table of document.querySelectorAll('table')) {
    const cells = labels(table, 'th, td');
    apart(cells, table.querySelector('caption')?.textContent ?? table.parentElement.id);
    for (const { node, at } of cells) if (!node.querySelector('svg, .scale') && !inside(at, node.getBoundingClientRect())) found.push(`table: "${words(node)}" leaves its cell`);
  }
  apart(labels(document, 'h1, h2, dt, dd, figcaption, summary, nav li, button, caption, .scale span'), 'text');
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), range = document.createRange();
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    if (!seen(node.parentElement) || node.parentElement.closest('script, style, noscript, .hash, svg, option')) continue;
    for (const word of node.data.matchAll(/[\\p{L}\\p{N}_]{2,}/gu)) {
      range.setStart(node, word.index);
      range.setEnd(node, word.index + word[0].length);
      const lines = [...range.getClientRects()].filter(({ width }) => width > 0);
      if (lines.some(({ top }) => Math.abs(top - lines[0].top) > 4)) found.push(`"${word[0]}" is broken`);
      if (lines.some(({ right, left }) => right > innerWidth + slack || left < -slack) && !node.parentElement.closest('.scroll')) found.push(`"${word[0]}" is outside of the window`);
    }
  }
  if (document.documentElement.scrollWidth > innerWidth) found.push(`it is ${document.documentElement.scrollWidth} px wide`);
  return [...new Set(found)];
}"""
AXE = """async (tags) => {
  // Marks of charts are parts of pictures, have no text, and are so many that axe takes seconds for them.
  document.querySelectorAll('.chart svg :is(circle, path, line, rect)').forEach((mark) => mark.remove());
  const { violations } = await axe.run(document, { runOnly: tags, resultTypes: ['violations'] });
  return violations.map(({ id, help, nodes }) => `${id}: ${help}: ${nodes.slice(0, 3).map(({ target }) => target.join(' ')).join(', ')}`);
}"""
WCAG_A_AND_AA = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]


def complaints(page):
    """What is wrong with the layout of what is shown."""
    return page.evaluate(COMPLAINTS, SLACK)


def violations(page):
    """What axe-core finds of WCAG A and AA; the page lacks the marks of its charts afterwards."""
    if not page.evaluate("typeof window.axe === 'object'"):
        page.evaluate(files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8"))
    return page.evaluate(AXE, WCAG_A_AND_AA)
