//! Writes a GLB with a hilly grid of 2 N x N triangles, for measuring what size costs: N = 2237 makes 10 million.
//!
//!     cargo run --release -p pt-import --example make_grid -- 2237 grid.glb

use std::fs::File;
use std::io::{BufWriter, Error, Result, Write};

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [n, path] = &arguments[..] else { return Err(Error::other("usage: make_grid N FILE.glb")) };
    let n: u32 = n.parse().map_err(|e| Error::other(format!("{n}: {e}")))?;
    let vertices = (u64::from(n) + 1).pow(2);
    let triangles = 2 * u64::from(n).pow(2);
    let (attribute, list) = (12 * vertices, 12 * triangles);
    let total = 2 * attribute + list;
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1}},"indices":2}}]}}],
"accessors":[
{{"bufferView":0,"componentType":5126,"type":"VEC3","count":{vertices},"min":[-1,-0.1,-1],"max":[1,0.1,1]}},
{{"bufferView":1,"componentType":5126,"type":"VEC3","count":{vertices}}},
{{"bufferView":2,"componentType":5125,"type":"SCALAR","count":{}}}],
"bufferViews":[{{"buffer":0,"byteLength":{attribute}}},
{{"buffer":0,"byteOffset":{attribute},"byteLength":{attribute}}},
{{"buffer":0,"byteOffset":{},"byteLength":{list}}}],
"buffers":[{{"byteLength":{total}}}]}}"#,
        3 * triangles,
        2 * attribute,
    );
    let text = format!("{json:width$}", width = json.len().next_multiple_of(4));
    let word =
        |x: u64| u32::try_from(x).map(u32::to_le_bytes).map_err(|_| Error::other("too large for a GLB"));
    let mut out = BufWriter::new(File::create(path)?);
    out.write_all(b"glTF")?;
    for part in [2, 12 + 8 + text.len() as u64 + 8 + total, text.len() as u64] {
        out.write_all(&word(part)?)?;
    }
    out.write_all(b"JSON")?;
    out.write_all(text.as_bytes())?;
    out.write_all(&word(total)?)?;
    out.write_all(b"BIN\0")?;
    let at = |i: u32| 2.0 * i as f32 / n as f32 - 1.0;
    let grid = || (0..=n).flat_map(|z| (0..=n).map(move |x| (at(x), at(z))));
    for (x, z) in grid() {
        for value in [x, 0.1 * (9.0 * x).sin() * (7.0 * z).cos(), z] {
            out.write_all(&value.to_le_bytes())?;
        }
    }
    for (x, z) in grid() {
        let slope_x = 0.9 * (9.0 * x).cos() * (7.0 * z).cos();
        let slope_z = -0.7 * (9.0 * x).sin() * (7.0 * z).sin();
        let length = (slope_x * slope_x + 1.0 + slope_z * slope_z).sqrt();
        for value in [-slope_x / length, 1.0 / length, -slope_z / length] {
            out.write_all(&value.to_le_bytes())?;
        }
    }
    for z in 0..n {
        for x in 0..n {
            let a = z * (n + 1) + x;
            let (b, c, d) = (a + 1, a + n + 1, a + n + 2);
            for vertex in [a, c, b, b, c, d] {
                out.write_all(&vertex.to_le_bytes())?;
            }
        }
    }
    out.flush()
}
