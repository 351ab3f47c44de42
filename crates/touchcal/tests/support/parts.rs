//! Parts as triangles, made here: blocks of cells, and bodies turned on a lathe.
#![allow(dead_code, reason = "each test crate uses a part")]

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;

use nalgebra::{Point2, Point3};
use touchcal::geometry::{Polygon, TriangleMesh};

/// Vertices and triangles.
pub type Mesh = (Vec<Point3<f64>>, Vec<[u32; 3]>);

pub fn solid((vertices, triangles): &Mesh) -> TriangleMesh {
    TriangleMesh::new(vertices, triangles).expect("a closed surface")
}

/// The body of all cells of a grid whose middle is within.
pub fn cells(grid: [&[f64]; 3], is_within: impl Fn(Point3<f64>) -> bool) -> Mesh {
    let count = [grid[0].len(), grid[1].len(), grid[2].len()];
    let middle = |axis: usize, k: usize| 0.5 * (grid[axis][k] + grid[axis][k + 1]);
    let is_filled = |cell: [isize; 3]| {
        let inside = (0..3).all(|axis| cell[axis] >= 0 && (cell[axis] as usize) + 1 < count[axis]);
        inside && is_within(Point3::from(std::array::from_fn::<f64, 3, _>(|axis| middle(axis, cell[axis] as usize))))
    };
    let (mut vertices, mut triangles, mut index) = (Vec::new(), Vec::new(), HashMap::new());
    for i in 0..count[0] as isize {
        for j in 0..count[1] as isize {
            for k in 0..count[2] as isize {
                for axis in 0..3 {
                    // The face below this cell along the axis.
                    let cell = [i, j, k];
                    let mut below = cell;
                    below[axis] -= 1;
                    let (above, below) = (is_filled(cell), is_filled(below));
                    if above == below {
                        continue;
                    }
                    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                    let mut corners: [u32; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[a, b]| {
                        let mut node = cell;
                        node[u] += a;
                        node[v] += b;
                        *index.entry(node).or_insert_with(|| {
                            vertices.push(Point3::from(std::array::from_fn(|axis| grid[axis][node[axis] as usize])));
                            vertices.len() as u32 - 1
                        })
                    });
                    if above {
                        corners.reverse();
                    }
                    let [a, b, c, d] = corners;
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
    }
    (vertices, triangles)
}

/// Coordinates of an outline along x and y, in order, and others.
pub fn lines(outline: &Polygon, others: &[f64]) -> [Vec<f64>; 2] {
    let sorted = |along: &dyn Fn(&Point2<f64>) -> f64| {
        let mut all: Vec<f64> = outline.vertices().iter().map(along).chain(others.iter().copied()).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    };
    [sorted(&|p| p.x), sorted(&|p| p.y)]
}

/// A peg whose outline runs along x and y, in six layers.
pub fn peg(outline: &Polygon, length: f64) -> Mesh {
    let [xs, ys] = lines(outline, &[]);
    let zs: Vec<f64> = (0..=6).map(|k| length * f64::from(k) / 6.0).collect();
    cells([&xs, &ys, &zs], |p| outline.contains(&p.xy()))
}

/// A block of 60 mm with a hole whose outline runs along x and y.
pub fn block(hole: &Polygon, depth: f64) -> Mesh {
    let [xs, ys] = lines(hole, &[-0.03, 0.03]);
    cells([&xs, &ys, &[-depth - 0.01, -depth, 0.0]], |p| p.z < -depth || !hole.contains(&p.xy()))
}

/// What turning a line of (radius, height) makes, with `sides` sides: from below, outside to the
/// right; it begins and ends on the axis.
pub fn turned(line: &[(f64, f64)], sides: usize) -> Mesh {
    let angle = |k: usize| std::f64::consts::TAU * k as f64 / sides as f64;
    let mut vertices = Vec::new();
    let rings: Vec<Vec<u32>> = line
        .iter()
        .map(|&(r, z)| {
            let first = vertices.len() as u32;
            if r == 0.0 {
                vertices.push(Point3::new(0.0, 0.0, z));
                return vec![first; sides];
            }
            vertices.extend((0..sides).map(|k| Point3::new(r * angle(k).cos(), r * angle(k).sin(), z)));
            (0..sides as u32).map(|k| first + k).collect()
        })
        .collect();
    let mut triangles = Vec::new();
    for pair in rings.windows(2) {
        for k in 0..sides {
            let next = (k + 1) % sides;
            let [a, b, c, d] = [pair[0][k], pair[0][next], pair[1][next], pair[1][k]];
            triangles.extend([[a, b, c], [a, c, d]].into_iter().filter(|[p, q, r]| p != q && q != r && r != p));
        }
    }
    (vertices, triangles)
}

/// A round peg of so many sides, with its edge at the tip broken by `chamfer`.
pub fn round_peg(radius: f64, length: f64, chamfer: f64, sides: usize) -> Mesh {
    let tip = if chamfer > 0.0 { vec![(radius - chamfer, 0.0), (radius, chamfer)] } else { vec![(radius, 0.0)] };
    turned(&[vec![(0.0, 0.0)], tip, vec![(radius, length), (0.0, length)]].concat(), sides)
}

/// A round block with a round hole.
pub fn round_block(radius: f64, depth: f64, sides: usize) -> Mesh {
    let outside = radius + 0.02;
    let line = [
        (0.0, -depth - 0.01),
        (outside, -depth - 0.01),
        (outside, 0.0),
        (radius, 0.0),
        (radius, -depth),
        (0.0, -depth),
    ];
    turned(&line, sides)
}

/// An outline along x and y with its corners rounded, each by so many points on an arc.
pub fn rounded(outline: &Polygon, radius: f64, points: usize) -> Polygon {
    let n = outline.len();
    let v = outline.vertices();
    let corner = |i: usize| {
        let (to_last, to_next) = ((v[(i + n - 1) % n] - v[i]).normalize(), (v[(i + 1) % n] - v[i]).normalize());
        let centre = v[i] + (to_last + to_next) * radius;
        (0..points).map(move |k| {
            let (sin, cos) = (FRAC_PI_2 * k as f64 / (points - 1) as f64).sin_cos();
            centre - to_next * (radius * cos) - to_last * (radius * sin)
        })
    };
    Polygon::new((0..n).flat_map(corner).collect()).expect("an outline")
}

/// What lies between outlines at heights, of equally many points each: flat at both ends.
pub fn lofted(sections: &[(&Polygon, f64)]) -> Mesh {
    let mut mesh = Mesh::default();
    for pair in sections.windows(2) {
        walls(&mut mesh, (pair[0].0.vertices(), pair[0].1), (pair[1].0.vertices(), pair[1].1));
    }
    for (end, is_up) in [(sections.first(), false), (sections.last(), true)] {
        let (outline, z) = end.expect("a section");
        face(&mut mesh, outline.vertices(), *z, is_up);
    }
    mesh
}

/// A block of 60 mm and so thick, with a hole of any outline: so deep, or through it.
pub fn block_around(hole: &Polygon, depth: f64, thickness: f64) -> Mesh {
    block_with(&[(hole, 0.0), (hole, -depth)], thickness)
}

/// A block of 60 mm and so thick, with a hole between outlines at heights, of equally many points
/// each, from its top face down; through the block if the last is as low as its bottom.
pub fn block_with(hole: &[(&Polygon, f64)], thickness: f64) -> Mesh {
    let (around, (floor, low)) = (hole[0].0.vertices(), hole[hole.len() - 1]);
    let (floor, depth) = (floor.vertices(), -low);
    let right = (0..around.len()).fold(0, |best, i| if around[i].x > around[best].x { i } else { best });
    // From the hole's rightmost point straight to the outside, once round the hole the other way,
    // and back.
    let gate = Point2::new(0.03, around[right].y);
    let outside = [(-0.03, 0.03), (-0.03, -0.03), (0.03, -0.03)].map(|(x, y)| Point2::new(x, y));
    let outside = [&[gate, Point2::new(0.03, 0.03)], outside.as_slice()].concat();
    let inside = (0..=around.len()).map(|k| around[(right + around.len() - k) % around.len()]);
    let ring: Vec<Point2<f64>> = outside.iter().copied().chain([gate]).chain(inside).collect();
    let mut mesh = Mesh::default();
    face(&mut mesh, &ring, 0.0, true);
    walls(&mut mesh, (&outside, -thickness), (&outside, 0.0));
    for pair in hole.windows(2) {
        walls(&mut mesh, (pair[0].0.vertices(), pair[0].1), (pair[1].0.vertices(), pair[1].1));
    }
    if depth < thickness {
        face(&mut mesh, floor, -depth, true);
        face(&mut mesh, &outside, -thickness, false);
    } else {
        face(&mut mesh, &ring, -thickness, false);
    }
    mesh
}

/// Adds the sides between two outlines.
fn walls(mesh: &mut Mesh, (from, bottom): (&[Point2<f64>], f64), (to, top): (&[Point2<f64>], f64)) {
    for k in 0..from.len() {
        let next = (k + 1) % from.len();
        let [a, b] = [k, next].map(|i| Point3::new(from[i].x, from[i].y, bottom));
        let [d, c] = [k, next].map(|i| Point3::new(to[i].x, to[i].y, top));
        push(mesh, [a, b, c]);
        push(mesh, [a, c, d]);
    }
}

/// Adds a flat face, cutting off ear after ear.
fn face(mesh: &mut Mesh, outline: &[Point2<f64>], z: f64, is_up: bool) {
    let mut rest: Vec<Point2<f64>> = outline.to_vec();
    while rest.len() >= 3 {
        let n = rest.len();
        let corners = |i: usize| [rest[(i + n - 1) % n], rest[i], rest[(i + 1) % n]];
        let is_ear = |i: &usize| {
            let [a, b, c] = corners(*i);
            let is_left = |p: Point2<f64>, q: Point2<f64>, r: Point2<f64>| (q - p).perp(&(r - p)) >= 0.0;
            let holds = |p: &Point2<f64>| is_left(a, b, *p) && is_left(b, c, *p) && is_left(c, a, *p);
            (b - a).perp(&(c - b)) > 0.0 && !rest.iter().any(|p| ![a, b, c].contains(p) && holds(p))
        };
        let ear = (0..n).find(is_ear).expect("an ear");
        let [a, b, c] = corners(ear).map(|p| Point3::new(p.x, p.y, z));
        push(mesh, if is_up { [a, b, c] } else { [a, c, b] });
        rest.remove(ear);
    }
}

fn push((vertices, triangles): &mut Mesh, corners: [Point3<f64>; 3]) {
    let first = vertices.len() as u32;
    vertices.extend(corners);
    triangles.push([first, first + 1, first + 2]);
}

/// The outline of what [`turned`] makes of a radius.
pub fn polygon(radius: f64, sides: usize) -> Polygon {
    let angle = |k: usize| std::f64::consts::TAU * k as f64 / sides as f64;
    Polygon::new((0..sides).map(|k| Point2::new(radius * angle(k).cos(), radius * angle(k).sin())).collect())
        .expect("an outline")
}

/// As STL, in millimetres: binary.
pub fn stl((vertices, triangles): &Mesh) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        for &corner in triangle {
            vertices[corner as usize].iter().for_each(|c| bytes.extend(((1e3 * c) as f32).to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

/// As OBJ, in millimetres.
pub fn obj((vertices, triangles): &Mesh) -> String {
    let v: String = vertices.iter().map(|p| format!("v {} {} {}\n", 1e3 * p.x, 1e3 * p.y, 1e3 * p.z)).collect();
    let f: String = triangles.iter().map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1)).collect();
    v + &f
}
