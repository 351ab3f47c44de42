//! Meshes: STL as bytes and as text, OBJ; closed, or a complaint that says where.

use crate::support::parts;
use crate::support::parts::{Mesh, obj, peg, round_peg, solid, stl};
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use touchcal::geometry::{Polygon, TriangleMesh};
use touchcal::io::mesh::read;
use touchcal::io::problem_file;

const MM: f64 = 1e-3;
const WITH_MESHES: &str = r#"
[robot]
builtin = "iiwa14"
[tool]
kind = "peg"
mesh = "peg.stl"
[[fixture]]
name = "hole"
kind = "hole"
mesh = "hole.stl"
depth_mm = 30
base_from_fixture = { xyz_mm = [600, 0, 100] }
[[contacts]]
file = "log.csv"
fixture = "hole"
[estimate]
parameters = ["strain"]
"#;

fn stl_text((vertices, triangles): &Mesh) -> String {
    let facets: String = triangles
        .iter()
        .map(|corners| {
            let vertex = |i: u32| {
                let p = vertices[i as usize] * 1e3;
                format!("      vertex {:e} {} {}\n", p.x, p.y, p.z)
            };
            let corners: String = corners.map(vertex).concat();
            format!("  facet normal 0 0 0\n    outer loop\n{corners}    endloop\n  endfacet\n")
        })
        .collect();
    format!("solid peg\n{facets}endsolid peg\n")
}

fn small() -> Mesh {
    parts::turned(&[(0.0, 0.0), (0.005, 0.0), (0.004, 0.01), (0.0, 0.01)], 5)
}

fn refused(bytes: impl AsRef<[u8]>, file: &str, parts: &[&str]) {
    let message = read(bytes.as_ref(), file, MM).unwrap_err().to_string();
    for part in parts.iter().chain(&[file]) {
        assert!(message.contains(part), "{part} is not in: {message}");
    }
}

/// Most that distances of two bodies differ around them.
fn apart(a: &TriangleMesh, b: &TriangleMesh) -> f64 {
    let mut chance = Pcg64::seed_from_u64(1);
    let mut point = || Point3::from(Vector3::from_fn(|_, _| chance.random_range(-0.03..0.03)));
    (0..200).map(|_| point()).map(|p| (a.signed_distance(&p).0 - b.signed_distance(&p).0).abs()).fold(0.0, f64::max)
}

#[test]
fn all_formats_are_the_same_body() {
    for mesh in [peg(&Polygon::extrusion25(), 0.04), round_peg(0.01, 0.04, 1e-3, 50)] {
        let body = solid(&mesh);
        let quads = obj(&mesh).replace("f ", "g part\nusemtl steel\nf ").replace("v ", "v  ");
        for (bytes, file, digits) in [
            (stl(&mesh), "a.stl", 1e-8),
            (stl_text(&mesh).into_bytes(), "a.STL", 1e-15),
            (obj(&mesh).into_bytes(), "a.obj", 1e-15),
            (quads.into_bytes(), "a.obj", 1e-15),
        ] {
            let read = read(&bytes, file, MM).unwrap();
            assert_eq!(read.triangle_count(), mesh.1.len());
            assert!(apart(&body, &read) < digits, "{file}: {:e}", apart(&body, &read));
        }
        let inches = read(&stl(&mesh), "a.stl", 25.4e-3).unwrap();
        assert!((inches.volume() / body.volume() / 25.4_f64.powi(3) - 1.0).abs() < 1e-6);
    }
    // Faces of four and more corners, named from the end.
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1 # top\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvn 0 0 1\nf 4 3 2 1\nf 5/1/1 6//1 7/2 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf -5 -8 -4 -1\n";
    assert!((read(cube.as_bytes(), "cube.obj", MM).unwrap().volume() - 1e-9).abs() < 1e-20);
}

#[test]
fn a_body_turned_inside_out_is_turned_back() {
    let (vertices, mut triangles) = small();
    let body = solid(&(vertices.clone(), triangles.clone()));
    triangles.iter_mut().for_each(|corners| corners.reverse());
    assert!(apart(&body, &solid(&(vertices, triangles))) < 1e-15);
}

/// One mesh of two.
fn joined((vertices, triangles): &Mesh, (others, of_others): &Mesh) -> Mesh {
    let first = vertices.len() as u32;
    let of_others = of_others.iter().map(|corners| corners.map(|corner| corner + first));
    ([vertices.as_slice(), others].concat(), triangles.iter().copied().chain(of_others).collect())
}

#[test]
fn bodies_are_counted_and_several_are_noted() {
    let (vertices, triangles) = small();
    let changed = |change: &dyn Fn(Point3<f64>) -> Point3<f64>| -> Vec<_> {
        vertices.iter().map(|&vertex| change(vertex)).collect()
    };
    let aside = (changed(&|vertex| vertex + Vector3::new(0.2, 0.0, 0.0)), triangles.clone());
    let middle = Point3::new(0.0, 0.0, 0.005);
    let inside_out: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let cavity = (changed(&|vertex| middle + 0.5 * (vertex - middle)), inside_out);
    let within = (changed(&|vertex| middle + 0.2 * (vertex - middle)), triangles.clone());
    // Two bodies that share the vertex of greatest x, one of them mirrored.
    let most = vertices.iter().map(|vertex| vertex.x).fold(0.0, f64::max);
    let mirrored = changed(&|vertex| Point3::new(2.0 * most - vertex.x, vertex.y, vertex.z));
    let touching = (mirrored, cavity.1.clone());
    let meshes = [
        (small(), 1),
        (joined(&small(), &aside), 2),
        (joined(&small(), &cavity), 1),
        (joined(&joined(&small(), &cavity), &within), 2),
        (joined(&small(), &touching), 1),
    ];
    for (mesh, expected) in meshes {
        assert_eq!(solid(&mesh).body_count(), expected);
    }

    let outline = Polygon::extrusion25();
    let hole = parts::block(&outline.offset_mitred(0.5e-3).unwrap(), 0.03);
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    write("peg.stl", &stl(&peg(&outline, 0.04)));
    write("log.csv", b"0,0.5,0,-1.5,0,1,0\n0,0.6,0,-1.5,0,1,0\n");
    let note_of = |hole: &Mesh| {
        write("hole.stl", &stl(hole));
        let loaded = problem_file::read(WITH_MESHES, "problem.toml", folder.path()).unwrap();
        let note = loaded.problem.contacts.notes().iter().find(|note| note.contains("bodies")).cloned();
        assert_eq!(loaded.assumptions.has_several_bodies(), note.is_some());
        note
    };
    assert_eq!(note_of(&hole), None);
    let expected = "meshes of several bodies, each of which can be touched: fixture `hole` (2); \
                    export what is meant as one closed surface";
    assert_eq!(note_of(&joined(&hole, &aside)).as_deref(), Some(expected));
}

#[test]
fn a_surface_that_is_not_closed_is_refused_with_the_place() {
    let (vertices, triangles) = small();
    let with = |triangles: &[[u32; 3]]| obj(&(vertices.clone(), triangles.to_vec()));
    refused(
        with(&triangles[1..]),
        "a.obj",
        &["closed surface", "(5.0000, 0.0000, 0.0000) mm", "has 1", "edges of that kind: 3"],
    );
    let twice = [triangles.as_slice(), &triangles[..1]].concat();
    refused(with(&twice), "a.obj", &["closed surface", "has 3"]);
    let mut turned = triangles.clone();
    turned[0].swap(0, 1);
    refused(with(&turned), "a.obj", &["same way round", " mm to (", "edges of that kind: 3"]);
    // A gap of 50 µm between two vertices that should be one.
    let torn = stl_text(&(vertices.clone(), triangles.clone())).replacen("vertex 5e0 0 0", "vertex 5.05e0 0 0", 1);
    refused(torn, "a.stl", &["closed surface", "has 1"]);
    let flat = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 3 2\nf 1 2 4\nf 2 1 4\n";
    refused(flat, "a.obj", &["triangle 2", "not on one line"]);
    refused("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\nf 1 2 3\nf 1 3 2\n", "a.obj", &["has 4"]);
    refused(with(&triangles[..3]), "a.obj", &["4 to 20000 triangles, found 3"]);
}

#[test]
fn what_is_no_mesh_is_refused_with_its_place() {
    let mesh = small();
    let binary = stl(&mesh);
    refused(&binary[..binary.len() - 1], "a.stl", &["1084 bytes, for the 20 triangles", "1083 bytes"]);
    let mut huge = binary.clone();
    huge[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    refused(&huge, "a.stl", &["4294967295 triangles"]);
    let mut nan = binary.clone();
    nan[84 + 50 + 12..84 + 50 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    refused(&nan, "a.stl", &["triangle 2", "finite", "NaN"]);
    refused("", "a.stl", &["an STL file", "0 bytes"]);
    let text = stl_text(&mesh);
    refused(
        text.replacen("vertex 5e0 0 0", "vertex 5 0 inf", 1),
        "a.stl",
        &["a.stl:", "three finite numbers", "vertex 5 0 inf"],
    );
    refused(text.replacen("vertex 5e0 0 0\n", "", 1), "a.stl", &["three vertices in a facet", "found 2"]);
    refused(text.replacen("outer loop", "outr loop", 1), "a.stl", &["a.stl:3", "outr loop"]);
    refused(text.replace("endsolid peg", ""), "a.stl", &["`endsolid` at the end"]);
    refused(b"solid \xff\xfe", "a.stl", &["UTF-8"]);
    refused("v 0 0\n", "a.obj", &["a.obj:1", "three finite numbers"]);
    refused("v 0 0 0\nf 1 2 3\n", "a.obj", &["a.obj:2", "1 vertices so far"]);
    refused("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.9 0.1 0\nf 1 2 3 4\n", "a.obj", &["a.obj:5", "do not overlap"]);
    refused("v 0 0 0\n", "a.obj", &["faces", "none"]);
    refused("v 0 0 20000\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", "a.obj", &["vertex 1", "±10 m"]);
    refused(
        "v 0 0 0\nv 0.02 0 0\nv 0 0.02 0\nf 1 2 3\n",
        "a.obj",
        &["0.1 mm across", "0.020 mm: looks like metres, see `mesh_unit`"],
    );
    let in_metres = read(b"v 0 0 25\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", "a.obj", 1.0).unwrap_err().to_string();
    assert!(in_metres.contains("looks like millimetres, see `mesh_unit`"), "{in_metres}");
    refused("x", "a.step", &["STL or OBJ", ".step"]);
}

/// No part of a file, and no damaged one, panics or hangs; none that is cut off is taken for a
/// body.
#[test]
fn cut_off_and_damaged_meshes_are_answered() {
    let mesh = small();
    let mut chance = Pcg64::seed_from_u64(7);
    let text = stl_text(&mesh);
    let object = obj(&mesh);
    for (bytes, file) in [(stl(&mesh), "a.stl"), (text.into_bytes(), "a.stl"), (object.into_bytes(), "a.obj")] {
        for end in 0..bytes.len() - 14 {
            assert!(read(&bytes[..end], file, MM).is_err(), "{file} cut off after {end} bytes");
        }
        for _ in 0..3000 {
            let mut damaged = bytes.clone();
            for _ in 0..chance.random_range(1..4) {
                let at = chance.random_range(0..damaged.len());
                damaged[at] ^= 1 << chance.random_range(0..8);
            }
            if let Ok(body) = read(&damaged, file, MM) {
                assert!(body.volume() > 0.0 && body.volume().is_finite());
            }
        }
    }
}
