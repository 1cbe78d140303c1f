//! Nodes of glTF files that ask for effects.

use crate::common::gltf::plain;
use crate::gltf_scenes::triangle;
use pt_import::load_bytes;
use pt_scene::glam::{Quat, Vec3};
use serde_json::json;

/// `extras.pt_effect` of a node.
#[test]
fn nodes_ask_for_effects() {
    let mut glb = triangle();
    let effects = [
        json!({"kind": "particle", "radius": 0.5, "radiance": [1, 2, 3], "velocity": [1, 0, 0], "period": 2}),
        json!({"kind": "beam", "radius": 0.1, "length": 2, "opacity": 0.5}),
        json!({"kind": "sprite", "size": [2, 1], "opacity": 1}),
        json!({"kind": "fog", "size": [2, 2, 4], "density": 0.3, "gradient": [0, -0.01, 0]}),
    ];
    let turn = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let nodes = effects.map(|effect| {
        let node = json!({"translation": [1, 2, 3], "scale": [2, 2, 2], "rotation": turn.to_array(), "extras": {"pt_effect": effect}});
        glb.push("nodes", node)
    });
    glb.json["scenes"][0]["nodes"] = json!([&[0], &nodes[..]].concat());
    let effects = glb.load_clean().effects;
    let near = |a: Vec3, b: [f32; 3]| assert!(a.abs_diff_eq(b.into(), 1e-5), "{a} for {b:?}");
    let particle = &effects.particles[0];
    near(particle.position, [1.0, 2.0, 3.0]);
    near(particle.look.radiance, [1.0, 2.0, 3.0]);
    near(particle.drift.velocity, [0.0, 0.0, -2.0]);
    assert!((particle.radius - 1.0).abs() < 1e-5 && particle.drift.period == 2.0);
    near(effects.beams[0].ends[1], [1.0, 6.0, 3.0]);
    near(effects.sprites[0].half_sides[0], [0.0, 0.0, -2.0]);
    near(effects.fog[0].corners[0], [-3.0, 0.0, 1.0]);
    near(effects.fog[0].corners[1], [5.0, 4.0, 5.0]);

    for (bad, what) in [
        (json!("smoke"), "invalid type"),
        (json!({"kind": "flame"}), "unknown variant `flame`"),
        (json!({"kind": "particle", "size": 1, "radius": 1}), "invalid type"),
        (json!({"kind": "particle", "radius": 1, "color": 1}), "unknown field `color`"),
        (json!({"kind": "particle"}), "radius is missing"),
        (json!({"kind": "sprite", "size": [0, 1]}), "span no area"),
        (json!({"kind": "fog", "size": [1, 1, 1], "density": -1}), "its density is -1 1/m"),
    ] {
        let mut glb = triangle();
        glb.json["nodes"][0]["extras"] = json!({"pt_effect": bad});
        let error = glb.load().unwrap_err().to_string();
        assert!(error.contains("nodes[0].extras.pt_effect") && error.contains(what), "{error}");
        assert_eq!(error.lines().count(), 1);
    }
    let mut glb = triangle();
    glb.json["nodes"][0]["rotation"] = json!(Quat::from_rotation_y(0.5).to_array());
    glb.json["nodes"][0]["extras"] = json!({"pt_effect": {"kind": "fog", "size": [1, 1, 1], "density": 1}});
    let error = glb.load().unwrap_err().to_string();
    assert!(error.contains("is turned"), "{error}");
    // A number above all others is no reason to take the effect for something of another program.
    let mut glb = triangle();
    glb.json["nodes"][0]["extras"] = json!({"pt_effect": {"kind": "particle", "radius": 11111}});
    let mut file = glb.file();
    let at = file.windows(5).position(|five| five == b"11111").unwrap();
    file[at..at + 5].copy_from_slice(b"1e400");
    let error = load_bytes(file, "test.glb", &plain()).unwrap_err().to_string();
    assert!(error.contains("nodes[0].extras.pt_effect: number out of range"), "{error}");
}
