// Asks the Vulkan loader what is there, before anything of the project is built. One line a finding on standard output:
//   fit NAME, Vulkan A.B.C, DRIVER      a device that can run the frame
//   unfit NAME, ...: REASON             a device that cannot
//   validation                          the Khronos validation layer loads
// A manifest in icd.d only promises a driver (Mesa's list GPUs that are not there), so the loader is called instead.
// No Vulkan headers: they are not there on a fresh machine, and these few structures never change.

#include <dlfcn.h>

#include <cstdint>
#include <cstdio>
#include <vector>

namespace {

struct ApplicationInfo {
    uint32_t type = 0;
    const void* next = nullptr;
    const char* application = "vulkan-probe";
    uint32_t application_version = 0;
    const char* engine = nullptr;
    uint32_t engine_version = 0;
    uint32_t api_version = 1u << 22 | 3u << 12;
};

struct InstanceCreateInfo {
    uint32_t type = 1;
    const void* next = nullptr;
    uint32_t flags = 0;
    const ApplicationInfo* application = nullptr;
    uint32_t layer_count = 0;
    const char* const* layers = nullptr;
    uint32_t extension_count = 0;
    const char* const* extensions = nullptr;
};

struct DriverProperties {
    uint32_t type = 1000196000;
    void* next = nullptr;
    uint32_t id = 0;
    char name[256] = {};
    char info[256] = {};
    uint8_t conformance[4] = {};
};

struct Properties2 {
    uint32_t type = 1000059001;
    void* next = nullptr;
    uint32_t api_version = 0;
    uint32_t driver_version = 0, vendor = 0, device = 0, kind = 0;
    char name[256] = {};
    alignas(8) uint8_t limits_and_more[1024] = {};  // 548 bytes in Vulkan 1.3; not looked at
};

using Function = void (*)();
using GetInstanceProcAddr = Function (*)(void* instance, const char* name);
using CreateInstance = int32_t (*)(const InstanceCreateInfo*, const void* allocator, void** instance);
using EnumeratePhysicalDevices = int32_t (*)(void* instance, uint32_t* count, void** devices);
using GetPhysicalDeviceProperties2 = void (*)(void* device, Properties2*);

constexpr uint32_t kDriverIdLlvmpipe = 13;

// Prints the line of one device; false when it cannot run the frame.
void report(void* device, GetPhysicalDeviceProperties2 get_properties) {
    DriverProperties driver;
    Properties2 properties;
    properties.next = &driver;
    get_properties(device, &properties);

    const unsigned major = properties.api_version >> 22 & 0x7f, minor = properties.api_version >> 12 & 0x3ff;
    const char* reason = nullptr;
    if (major < 1 || (major == 1 && minor < 3)) reason = "Vulkan 1.3 is needed";

    // lavapipe's driver_version is a constant: only the info text tells the Mesa release.
    unsigned mesa_major = 0, mesa_minor = 0;
    if (driver.id == kDriverIdLlvmpipe && std::sscanf(driver.info, "Mesa %u.%u", &mesa_major, &mesa_minor) == 2 &&
        (mesa_major < 24 || (mesa_major == 24 && mesa_minor < 1)))
        reason = "Mesa 24.1 or newer is needed";

    std::printf("%s %s, Vulkan %u.%u.%u, %s%s%s\n", reason ? "unfit" : "fit", properties.name, major, minor,
                properties.api_version & 0xfff, driver.info[0] ? driver.info : "driver unnamed", reason ? ": " : "",
                reason ? reason : "");
}

}  // namespace

int main() {
    void* loader = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!loader) return 0;
    const auto get = reinterpret_cast<GetInstanceProcAddr>(dlsym(loader, "vkGetInstanceProcAddr"));
    if (!get) return 0;
    const auto create = reinterpret_cast<CreateInstance>(get(nullptr, "vkCreateInstance"));
    if (!create) return 0;

    const ApplicationInfo application;
    InstanceCreateInfo info;
    info.application = &application;
    void* instance = nullptr;
    if (create(&info, nullptr, &instance) != 0) return 0;

    const auto enumerate = reinterpret_cast<EnumeratePhysicalDevices>(get(instance, "vkEnumeratePhysicalDevices"));
    const auto get_properties =
        reinterpret_cast<GetPhysicalDeviceProperties2>(get(instance, "vkGetPhysicalDeviceProperties2"));
    uint32_t count = 0;
    if (enumerate && get_properties && enumerate(instance, &count, nullptr) == 0 && count > 0) {
        std::vector<void*> devices(count);
        if (enumerate(instance, &count, devices.data()) == 0)
            for (uint32_t i = 0; i < count; ++i) report(devices[i], get_properties);
    }

    const char* const layer = "VK_LAYER_KHRONOS_validation";
    info.layer_count = 1;
    info.layers = &layer;
    void* validated = nullptr;
    if (create(&info, nullptr, &validated) == 0) std::puts("validation");
    return 0;
}
