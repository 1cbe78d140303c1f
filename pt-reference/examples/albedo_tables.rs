//! Writes the tables of directional albedos that the BSDF's energy compensation reads.

fn main() -> anyhow::Result<()> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders/glsl/bsdf_albedo.glsl");
    std::fs::write(path, pt_reference::oracle::albedo::header())?;
    println!("{path}");
    Ok(())
}
