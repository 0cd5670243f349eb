//! The URDF files of the package are what the node publishes, and the mesh that they name is a hull.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use planesman_plant::{PlantParameters, VehicleModel, robot_description};

#[test]
fn the_committed_files_are_what_is_published() {
    for (name, committed) in [
        (
            "brunner",
            include_str!("../../../../../launch-scripts/urdf/brunner.urdf"),
        ),
        (
            "remus_100",
            include_str!("../../../../../launch-scripts/urdf/remus_100.urdf"),
        ),
        (
            "lauv",
            include_str!("../../../../../launch-scripts/urdf/lauv.urdf"),
        ),
        (
            "bluerov2_heavy",
            include_str!("../../../../../launch-scripts/urdf/bluerov2_heavy.urdf"),
        ),
    ] {
        let parameters = PlantParameters {
            vehicle: name.to_owned(),
            ..PlantParameters::default()
        };
        let published = robot_description(&VehicleModel::load(&parameters).unwrap());
        assert!(
            published == committed,
            "write it anew: cargo run -p planesman_plant --example urdf {name} > launch-scripts/urdf/{name}.urdf"
        );
    }
}

/// The vertices and faces of an OBJ file, faces as indices of vertices.
fn mesh(text: &str) -> (Vec<[f64; 3]>, Vec<Vec<usize>>) {
    let rows = |key| {
        let lines = text.lines().filter_map(move |line| line.strip_prefix(key));
        lines.map(|line| line.split_whitespace())
    };
    let vertices = rows("v ").map(|row| {
        let row: Vec<f64> = row.map(|it| it.parse().unwrap()).collect();
        row.try_into().unwrap()
    });
    let faces = rows("f ").map(|row| row.map(|it| it.parse::<usize>().unwrap() - 1).collect());
    (vertices.collect(), faces.collect())
}

#[test]
fn the_mesh_of_the_hull_is_closed_and_displaces_what_a_cylinder_of_radius_1_does() {
    let (vertices, faces) = mesh(include_str!(
        "../../../../../launch-scripts/meshes/hull.obj"
    ));
    let along = vertices.iter().map(|it| it[0]);
    assert_eq!(along.clone().fold(f64::MIN, f64::max), 0.5);
    assert_eq!(along.fold(f64::MAX, f64::min), -0.5);

    let mut edges = BTreeSet::new();
    let mut volume = 0.0;
    for face in &faces {
        for (i, from) in face.iter().enumerate() {
            assert!(
                edges.insert((*from, face[(i + 1) % face.len()])),
                "{face:?}"
            );
        }
        for corner in 1..face.len() - 1 {
            let [a, b, c] = [face[0], face[corner], face[corner + 1]].map(|it| vertices[it]);
            let cross = [
                b[1] * c[2] - b[2] * c[1],
                b[2] * c[0] - b[0] * c[2],
                b[0] * c[1] - b[1] * c[0],
            ];
            volume += (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0;
        }
    }
    // Each edge belongs to two faces, which run along it against each other.
    assert!(edges.iter().all(|(from, to)| edges.contains(&(*to, *from))));
    assert!((volume - PI).abs() < 1e-3, "{volume}");
}
