//! Tells the tests whether the shared test data are there, and the Python modules of the example.

fn main() {
    pt_test_data::declare();
    println!("cargo::rustc-check-cfg=cfg(python_openexr)");
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/python/numpy/version.py");
    println!("cargo::rerun-if-changed=build.rs");
    if std::path::Path::new(file).exists() {
        println!("cargo::rerun-if-changed={file}");
        println!("cargo::rustc-cfg=python_openexr");
    }
}
