//! Tells the tests whether there is a browser for them.

fn main() {
    pt_test_data::declare_browser();
}
