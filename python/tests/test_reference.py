"""The guide's Python reference is what docstrings and stubs say. ``TOUCHCAL_UPDATE=1 scripts/test_python`` writes it anew."""

import ast
import inspect
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import ModuleType

import touchcal
from touchcal import _bar, _touchcal, correction, distributed, plots

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "guide/src/python.md"
WIDTH = 100
SECTIONS = {"Args:", "Attributes:", "Raises:", "Returns:"}


def markdown(docstring: str | None) -> str:
    """A docstring's sections as lists, its indented blocks as code."""
    assert docstring, "everything public is documented"
    text = inspect.cleandoc(docstring).replace("``", "`") + "\n"
    block = r":?:\n\n((?:    .*\n|\n)+)"
    text = re.sub(block, lambda code: f":\n\n```python\n{inspect.cleandoc(code[1])}\n```\n\n", text)
    text = re.sub(r"^:\n\n", "", text, flags=re.MULTILINE)
    lines = []
    for line in text.splitlines():
        if line in SECTIONS:
            line = f"**{line[:-1]}**\n"
        elif (entry := re.match(r"    ( *)(\S.*)", line)) and lines[-1].startswith("- ") and (entry[1] or lines[-1][-1] != "."):
            # A continuation line is indented further, or follows one that ends within a sentence.
            line = f"{lines.pop()} {entry[2]}"
        elif entry:
            name, colon, meaning = entry[2].partition(": ")
            line = f"- `{name}`: {meaning}" if colon and re.fullmatch(r"[\w*, ]+", name) else f"- {entry[2]}"
        lines.append(line.rstrip())
    return "\n".join(lines).strip()


def one_sentence_a_line(text: str) -> str:
    """Markdown with its sentences on lines of their own; code stays as it is."""
    blocks = re.split(r"(^```.*?^```$)", text, flags=re.MULTILINE | re.DOTALL)
    prose = r"(?<=[\w`)\]])([.?]) (?=[A-Z`*\[])"
    return "".join(block if block.startswith("```") else re.sub(prose, r"\1\n", block) for block in blocks)


def signature(function: ast.FunctionDef, owner: str = "") -> str:
    """A function's first line, one argument a line where it is long."""
    arguments = ast.unparse(function.args).removeprefix("self, ").removeprefix("self")
    returns = f" -> {ast.unparse(function.returns)}" if function.returns else ""
    whole = f"{owner}{function.name}({arguments}){returns}"
    if len(whole) > WIDTH:
        each = re.split(r", (?![^\[]*\])", arguments)
        whole = f"{owner}{function.name}(\n" + "".join(f"    {argument},\n" for argument in each) + f"){returns}"
    return re.sub(r"\b(npt\.|pd\.|_(?=[A-Z]))", "", whole)


def is_property(function: ast.FunctionDef) -> bool:
    return any(isinstance(mark, ast.Name) and mark.id == "property" for mark in function.decorator_list)


def member(owner: type, function: ast.FunctionDef) -> str:
    docstring = getattr(owner, function.name).__doc__
    if not is_property(function):
        return f"\n```python\n{signature(function, owner.__name__ + '.')}\n```\n\n{markdown(docstring)}\n"
    if docstring is None:
        attribute = rf"^    .*\b{function.name}\b.*: "
        assert re.search(attribute, owner.__doc__ or "", re.MULTILINE), f"{owner.__name__}.{function.name}"
        return ""
    return f"- `{function.name}: {signature(function).partition(' -> ')[2]}`: {markdown(docstring)}"


def described(module: ModuleType, tree: ast.Module) -> Iterator[str]:
    """What a module has, in the order of its text."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name in module.__all__:
            meaning = markdown(getattr(module, node.name).__doc__)
            yield f"## {node.name}\n\n```python\n{signature(node)}\n```\n\n{meaning}\n"
        elif isinstance(node, ast.ClassDef) and node.name in module.__all__:
            owner = getattr(module, node.name)
            yield f"## {node.name}\n\n{markdown(owner.__doc__)}\n"
            functions = [part for part in node.body if isinstance(part, ast.FunctionDef) and part.name[0] != "_"]
            yield from (member(owner, function) for function in sorted(functions, key=is_property))
            yield ""


def submodule(module: ModuleType) -> Iterator[Iterable[str]]:
    yield [f"# {module.__name__}\n", markdown(module.__doc__), ""]
    yield described(module, ast.parse(Path(module.__file__ or "").read_text()))


def page() -> str:
    stubs = Path(_touchcal.__file__).with_name("_touchcal.pyi")
    parts: list[Iterable[str]] = [
        ["# Python reference\n", markdown(touchcal.__doc__), ""],
        described(_touchcal, ast.parse(stubs.read_text())),
        described(touchcal, ast.parse(Path(_bar.__file__).read_text())),
        *(part for module in (correction, plots, distributed) for part in submodule(module)),
    ]
    text = "\n".join(line for part in parts for line in part)
    return one_sentence_a_line(re.sub(r"\n{3,}", "\n\n", text)).strip() + "\n"


def test_the_guides_reference_is_what_the_code_says() -> None:
    found = page()
    public = {name for name in touchcal.__all__ if not name.startswith("_")}
    assert public <= set(re.findall(r"^## (\w+)", found, re.MULTILINE))
    if os.environ.get("TOUCHCAL_UPDATE") == "1":
        PAGE.write_text(found)
    assert PAGE.read_text() == found
