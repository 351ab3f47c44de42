//! Outlines from drawings: the same as their vertices where they are straight, within a micrometre
//! where they are round, and everything else refused with file and line.

use std::fmt::Write as _;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use touchcal::geometry::Polygon;
use touchcal::io::outline::{Choice, TOLERANCE, read};

const ANY: Choice<'static> = Choice { name: None, unit: None };

fn svg(content: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<!DOCTYPE svg PUBLIC \"-//W3C//DTD SVG 1.1//EN\" \"http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd\">\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"30mm\" height=\"30mm\" viewBox=\"-15 -15 30 30\">\n{content}\n</svg>\n"
    )
}

/// A drawing of entities, each a text of codes and values separated by blanks.
fn dxf(units: &str, entities: &[&str]) -> String {
    let mut text = format!("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n{units}\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n");
    for entity in entities {
        entity.split_whitespace().for_each(|word| writeln!(text, "{word}").unwrap());
    }
    text + "0\nENDSEC\n0\nEOF\n"
}

fn drawn(content: &str) -> Polygon {
    read(svg(content).as_bytes(), "peg.svg", ANY).unwrap()
}

fn refused(text: &str, file: &str, choice: Choice<'_>, parts: &[&str]) {
    let message = read(text.as_bytes(), file, choice).unwrap_err().to_string();
    for part in parts.iter().chain(&[file]) {
        assert!(message.contains(part), "{part} is not in: {message}");
    }
}

/// Most that the vertices and middles of edges are off a circle about the origin.
fn off_circle(profile: &Polygon, radius: f64) -> f64 {
    let off = |p: &nalgebra::Point2<f64>| (p.coords.norm() - radius).abs();
    (0..profile.len())
        .flat_map(|i| {
            let (a, b) = profile.edge(i);
            [off(&a), off(&nalgebra::center(&a, &b))]
        })
        .fold(0.0, f64::max)
}

/// Most that the vertices of one are from those of the other, in any order.
fn apart(a: &Polygon, b: &Polygon) -> f64 {
    assert_eq!(a.len(), b.len());
    assert!((a.area() - b.area()).abs() < 1e-12, "{} {}", a.area(), b.area());
    let nearest = |p: &nalgebra::Point2<f64>| b.vertices().iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
    a.vertices().iter().map(nearest).fold(0.0, f64::max)
}

/// The T-slot's corners in mm, y down as in an SVG.
fn extrusion_points() -> String {
    let pairs =
        Polygon::extrusion25().vertices().iter().map(|p| format!("{},{}", 1e3 * p.x, -1e3 * p.y)).collect::<Vec<_>>();
    pairs.join(" ")
}

/// A circle of 100 mm takes more pieces of a micrometre than an outline may have.
#[test]
fn a_large_circle_has_pieces_within_six_micrometres() {
    let drawing = "<svg viewBox='0 0 200 200' width='200mm' height='200mm'><circle cx='100' cy='100' r='100'/></svg>";
    let outline = read(drawing.as_bytes(), "a.svg", ANY).unwrap();
    let centre = nalgebra::Point2::new(0.1, -0.1);
    let off = (0..outline.len()).map(|k| {
        let (a, b) = outline.edge(k);
        (0.1 - (nalgebra::center(&a, &b) - centre).norm()).abs().max(((a - centre).norm() - 0.1).abs())
    });
    let most = off.fold(0.0, f64::max);
    println!("{} pieces, {most:.2e} m", outline.len());
    assert!((200..512).contains(&outline.len()) && (1e-6..6e-6).contains(&most), "{} {most}", outline.len());
}

#[test]
fn straight_drawings_are_their_vertices() {
    let csv: String = Polygon::extrusion25()
        .vertices()
        .iter()
        .fold("x_mm,y_mm\n".to_owned(), |text, p| format!("{text}{},{}\n", 1e3 * p.x, 1e3 * p.y));
    let vertices = read(csv.as_bytes(), "peg.csv", ANY).unwrap();
    let points = extrusion_points();
    let (first, rest) = points.split_once(' ').unwrap();
    let corners: String =
        Polygon::extrusion25().vertices().iter().map(|p| format!(" 10 {} 20 {}", 1e3 * p.x, 1e3 * p.y)).collect();
    let lines: Vec<String> = (0..36)
        .map(|i| {
            let (a, b) = Polygon::extrusion25().edge((7 * i) % 36);
            // Every other one drawn backwards.
            let (a, b) = if i % 2 == 0 { (a, b) } else { (b, a) };
            format!("0 LINE 8 peg 10 {} 20 {} 11 {} 21 {}", 1e3 * a.x, 1e3 * a.y, 1e3 * b.x, 1e3 * b.y)
        })
        .collect();
    let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
    let drawings = [
        drawn(&format!("<polygon points=\"{points}\"/>")),
        drawn(&format!(
            "<g transform=\"translate(3,2) scale(2)\"><path transform=\"scale(0.5) translate(-3 -2)\" d=\"M {first} L {rest} Z\"/></g>"
        )),
        read(dxf("4", &[&format!("0 LWPOLYLINE 8 peg 90 36 70 1{corners}")]).as_bytes(), "peg.dxf", ANY).unwrap(),
        read(dxf("4", &lines).as_bytes(), "peg.dxf", ANY).unwrap(),
    ];
    for drawing in drawings {
        assert!(apart(&drawing, &vertices) < 1e-15, "{}", apart(&drawing, &vertices));
    }
}

#[test]
fn round_drawings_are_within_a_micrometre_of_the_curve() {
    let bulges = "0 LWPOLYLINE 8 0 90 2 70 1 10 -10 20 0 42 1 10 10 20 0 42 1";
    let inches = dxf("1", &["0 CIRCLE 8 0 10 0 20 0 40 0.39370078740157"]);
    let halves = ["0 ARC 8 0 10 0 20 0 40 10 50 0 51 180", "0 ARC 8 0 10 0 20 0 40 10 50 180 51 360"];
    let old = "0 POLYLINE 8 0 70 1 0 VERTEX 8 0 10 -10 20 0 42 1 0 VERTEX 8 0 10 10 20 0 42 1 0 SEQEND";
    let mirrored = [
        "0 ARC 8 0 10 0 20 0 40 10 50 0 51 90 210 0 220 0 230 -1",
        "0 ARC 8 0 10 0 20 0 40 10 50 90 51 180",
        "0 LINE 8 0 10 -10 20 0 11 -10 21 0",
        "0 ARC 8 0 10 0 20 0 40 10 50 180 51 90",
    ];
    let circles = [
        drawn("<circle r=\"10\"/>"),
        drawn("<rect x=\"-10\" y=\"-10\" width=\"20\" height=\"20\" rx=\"10\"/>"),
        drawn("<path d=\"M-10,0 a10 10 0 0 1 20,0 A 10,10 0 1 1 -10 0z\"/>"),
        drawn("<ellipse rx=\"5\" ry=\"10\" transform=\"scale(2 1)\"/>"),
        read(dxf("4", &[bulges]).as_bytes(), "a.dxf", ANY).unwrap(),
        read(dxf("4", &[old]).as_bytes(), "a.dxf", ANY).unwrap(),
        read(dxf("4", &halves).as_bytes(), "a.dxf", ANY).unwrap(),
        read(inches.as_bytes(), "a.dxf", ANY).unwrap(),
        read(
            dxf("0", &["0 ELLIPSE 8 0 10 0 20 0 11 0 21 -1 40 1"]).as_bytes(),
            "a.dxf",
            Choice { unit: Some(1e-2), ..ANY },
        )
        .unwrap(),
    ];
    for (k, circle) in circles.iter().enumerate() {
        assert!(off_circle(circle, 0.01) <= TOLERANCE, "{k}: {}", off_circle(circle, 0.01));
        assert!(circle.len() < 1000, "{k}: {}", circle.len());
    }
    // From behind: the first quarter lies on the left, where the second is drawn too, so that the
    // circle is open.
    refused(&dxf("4", &mirrored), "a.dxf", ANY, &["a closed outline"]);
}

#[test]
fn curves_of_a_path_are_what_svg_says_they_are() {
    // Against the definition of the curves: cubics with mirrored control points, relative and
    // absolute.
    let profile = drawn("<path d=\"M -10 0 C -10 -5 -5 -10 0 -10 S 10 -5 10 0 q 0 5 -5 5 t -5 5 H -10 V 0\"/>");
    let cubic = |p: [(f64, f64); 4], t: f64| {
        let w = [(1.0 - t).powi(3), 3.0 * t * (1.0 - t).powi(2), 3.0 * t * t * (1.0 - t), t.powi(3)];
        let (x, y) = (0..4).fold((0.0, 0.0), |(x, y), k| (x + w[k] * p[k].0, y + w[k] * p[k].1));
        nalgebra::Point2::new(1e-3 * x, -1e-3 * y)
    };
    let quadratic = |a: (f64, f64), b: (f64, f64), c: (f64, f64), t: f64| {
        let third = |p: f64, q: f64| p + (q - p) * 2.0 / 3.0;
        cubic([a, (third(a.0, b.0), third(a.1, b.1)), (third(c.0, b.0), third(c.1, b.1)), c], t)
    };
    for k in 0..=200 {
        let t = f64::from(k) / 200.0;
        let points = [
            cubic([(-10.0, 0.0), (-10.0, -5.0), (-5.0, -10.0), (0.0, -10.0)], t),
            cubic([(0.0, -10.0), (5.0, -10.0), (10.0, -5.0), (10.0, 0.0)], t),
            quadratic((10.0, 0.0), (10.0, 5.0), (5.0, 5.0), t),
            quadratic((5.0, 5.0), (0.0, 5.0), (0.0, 10.0), t),
        ];
        for point in points {
            assert!(profile.signed_distance(&point).abs() <= TOLERANCE, "{t}: {}", profile.signed_distance(&point));
        }
    }
}

#[test]
fn the_part_asked_for_is_read() {
    let two = svg(
        "<g id=\"parts\"><circle id=\"peg\" r=\"10\"/></g>\n<rect id=\"frame\" x=\"-14\" y=\"-14\" width=\"28\" height=\"28\"/>\n<g style=\"display: none\"><circle r=\"1\"/></g><defs><circle r=\"2\"/></defs>",
    );
    refused(
        &two,
        "a.svg",
        ANY,
        &["one closed outline", "outline_name", "2 (<circle id=\"peg\"> in line 4, <rect id=\"frame\"> in line 5)"],
    );
    for name in ["peg", "parts"] {
        let peg = read(two.as_bytes(), "a.svg", Choice { name: Some(name), unit: None }).unwrap();
        assert!(off_circle(&peg, 0.01) <= TOLERANCE);
    }
    refused(&two, "a.svg", Choice { name: Some("pge"), unit: None }, &["id \"pge\"", "did you mean `peg`"]);
    let two = dxf("6", &["0 CIRCLE 8 peg 10 0 20 0 40 0.01", "0 CIRCLE 8 frame 10 0 20 0 40 0.02", "0 SPLINE 8 frame"]);
    let peg = read(two.as_bytes(), "a.dxf", Choice { name: Some("peg"), unit: None }).unwrap();
    assert!(off_circle(&peg, 0.01) <= TOLERANCE);
    refused(&two, "a.dxf", Choice { name: Some("frame"), unit: None }, &["SPLINE", "a.dxf:"]);
    refused(&two, "a.dxf", Choice { name: Some("pegs"), unit: None }, &["layer \"pegs\"", "did you mean `peg`"]);
}

#[test]
fn what_is_no_outline_is_refused_with_its_place() {
    let open = svg("<path d=\"M 0 0 H 10 V 10 H 0.01\"/>");
    refused(&open, "a.svg", ANY, &["a.svg:4", "a closed outline", "(0.010000, -10.000000) mm", "mm from where"]);
    let unitless = open.replace("width=\"30mm\" height=\"30mm\" ", "");
    refused(&unitless, "a.svg", ANY, &["`outline_unit`", "neither"]);
    refused(&open, "a.svg", Choice { unit: Some(25.4e-3), ..ANY }, &["25.4 mm", "a unit of 1 mm"]);
    refused(&open.replace("height=\"30mm\"", "height=\"40mm\""), "a.svg", ANY, &["viewBox", "one unit"]);
    refused(&svg("<use href=\"#a\"/>"), "a.svg", ANY, &["a.svg:4", "<use>"]);
    refused(&svg("<path d=\"M 0 0 L 1 NaN\"/>"), "a.svg", ANY, &["a.svg:4", ", d:", "path"]);
    refused(&svg("<circle r=\"1e30\"/>"), "a.svg", ANY, &["a.svg:4", ", r", "1e30"]);
    refused(&svg("<polygon points=\"0,0 1,1 2\"/>"), "a.svg", ANY, &["points", "pairs of numbers"]);
    refused(&svg("<path d=\"M 0 0 L 1e999 0 L 1 1 z\"/>"), "a.svg", ANY, &["a.svg:4", "invalid number"]);
    refused(&svg("<path d=\"M 0 0 A 1e300 1e300 0 0 0 1e5 1 L 1 1 z\"/>"), "a.svg", ANY, &["coordinates within ±10 m"]);
    refused(&svg("<text>peg</text>"), "a.svg", ANY, &["a closed outline, found none"]);
    refused(&svg("<path d=\"M0 0 L 10 10 L 10 0 L 0 10 z\"/>"), "a.svg", ANY, &["does not meet itself"]);
    refused("<html/>", "a.svg", ANY, &["<html>"]);
    let laughs = "<!DOCTYPE svg [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\"><!ENTITY c \"&b;&b;&b;&b;&b;&b;\"><!ENTITY d \"&c;&c;&c;&c;&c;&c;&c;&c;\"><!ENTITY e \"&d;&d;&d;&d;&d;&d;\"> <!ENTITY f \"&e;&e;&e;&e;&e;&e;&e;\">]><svg><text>&f;&f;&f;&f;&f;&f;&f;&f;</text></svg>";
    refused(laughs, "a.svg", ANY, &["well-formed"]);

    refused(&dxf("0", &["0 CIRCLE 8 0 10 0 20 0 40 1"]), "a.dxf", ANY, &["$INSUNITS", "`outline_unit`"]);
    refused(&dxf("17", &[]), "a.dxf", ANY, &["a.dxf:8", "$INSUNITS", "\"17\""]);
    refused(&dxf("4", &["0 CIRCLE 8 0 10 0 20 inf 40 1"]), "a.dxf", ANY, &["a.dxf:22", "group 20", "\"inf\""]);
    refused(&dxf("4", &["0 CIRCLE 8 0 10 0 20 0"]), "a.dxf", ANY, &["CIRCLE", "group 40", "none"]);
    refused(&dxf("4", &["0 CIRCLE 8 0 10 0 20 0 40 1e9"]), "a.dxf", ANY, &["radii of at most"]);
    refused(&dxf("4", &["0 ARC 8 0 10 0 20 0 40 1 50 0 51 90"]), "a.dxf", ANY, &["a.dxf:16, ARC", "a closed outline"]);
    refused(&dxf("4", &["0 CIRCLE 8 0 10 0 20 0 40 1 210 1"]), "a.dxf", ANY, &["plane of x and y"]);
    refused("AutoCAD Binary DXF\r\n", "a.dxf", ANY, &["a binary one"]);
    refused("", "a.dxf", ANY, &["EOF"]);
    refused("0\nSECTION\n", "a.dxf", ANY, &["EOF"]);
    refused("hello\n", "a.dxf", ANY, &["a.dxf:1", "group code", "hello"]);
    refused("1,2\n", "a.csv", Choice { name: Some("peg"), ..ANY }, &["`outline_name`"]);
    assert!(read(b"\xff\xfe", "a.dxf", ANY).unwrap_err().to_string().contains("UTF-8"));
}

/// No part of a file, and no damaged one, panics, hangs, or is taken for an outline of absurd size.
#[test]
fn cut_off_and_damaged_drawings_are_answered() {
    let path = svg(&format!("<g id=\"a\" transform=\"rotate(3)\"><path d=\"M {} z\"/></g>", extrusion_points()));
    let arcs = svg(
        "<path d=\"M-10,0 a10 10 0 0 1 20,0 Q 1,2 3.5,4 T 2 1 C 1 2 3 4 -5 5 s 1 2 3 4 A 10,10 0 1 1 -10 0z\"/><ellipse rx=\"5\" ry=\"10\"/>",
    );
    let bulges = dxf(
        "4",
        &["0 LWPOLYLINE 8 0 90 2 70 1 10 -10 20 0 42 0.5 10 10 20 0 42 1", "0 ELLIPSE 8 0 10 0 20 0 11 0 21 -1 40 1"],
    );
    let mut chance = Pcg64::seed_from_u64(5);
    for (text, file) in [(&path, "a.svg"), (&arcs, "a.svg"), (&bulges, "a.dxf")] {
        let bytes = text.as_bytes();
        let last = bytes.len() - 8;
        for end in 0..last {
            assert!(read(&bytes[..end], file, ANY).is_err(), "{file} cut off after {end} bytes");
        }
        for _ in 0..3000 {
            let mut damaged = bytes.to_vec();
            for _ in 0..chance.random_range(1..4) {
                let at = chance.random_range(0..damaged.len());
                damaged[at] ^= 1 << chance.random_range(0..8);
            }
            if let Ok(profile) = read(&damaged, file, ANY) {
                assert!(profile.bounding_radius() < 15.0);
            }
        }
    }
}
