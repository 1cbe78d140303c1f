//! Compiles the kernels of `shaders/` and of the tests.

use pt_shaders::GpuStruct;

mod test_records {
    include!("tests/common/records.rs");
}

mod offset_records {
    include!("tests/common/offset_records.rs");
}

mod trace_push {
    include!("src/trace/push.rs");
}

fn main() {
    let kernels = pt_shaders::compiler::Kernels::new();
    let kernels = kernels.header("ray_list_push.glsl", trace_push::RayListPush::glsl());
    let refit =
        [trace_push::RefitPush::glsl(), trace_push::RefitNode::glsl(), trace_push::NodeBounds::glsl()];
    let kernels = kernels.header("refit_records.glsl", refit.concat());
    kernels.compile("shaders");
    let test_header = [
        test_records::TestPush::glsl(),
        offset_records::OffsetPush::glsl(),
        offset_records::OffsetStart::glsl(),
    ];
    kernels.header("test_records.glsl", test_header.concat()).compile_as("tests/shaders", "test_kernels.rs");
}
