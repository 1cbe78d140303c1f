//! Tells the tests whether the shared test data are there.

fn main() {
    pt_test_data::declare();
}
