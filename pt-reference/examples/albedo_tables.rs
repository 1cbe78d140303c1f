//! Writes the tables of directional albedos that the BSDF's energy compensation reads.

fn main() -> anyhow::Result<()> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/oracle/albedo_tables.txt");
    std::fs::write(path, pt_reference::oracle::albedo::text())?;
    println!("{path}");
    Ok(())
}
