//! Writes the tables of directional albedos that the BSDF's energy compensation reads.

fn main() -> anyhow::Result<()> {
    let path = pt_scene::bsdf_tables::FILE;
    std::fs::write(path, pt_reference::oracle::albedo::text())?;
    println!("{path}");
    Ok(())
}
