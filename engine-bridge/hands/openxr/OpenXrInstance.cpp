#include "engine-bridge/hands/openxr/OpenXrInstance.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include <dlfcn.h>
#include <fmt/format.h>
#include <openxr/openxr_reflection.h>

namespace midair::bridge
{

namespace
{

constexpr std::array<const char*, 3> kNeeded = {XR_EXT_HAND_TRACKING_EXTENSION_NAME,
                                                XR_MND_HEADLESS_EXTENSION_NAME,
                                                XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME};

/// A larger count from the runtime is lowered to this.
constexpr std::uint32_t kMostExtensions = 10000;

/// A runtime's text may fill its array without a terminating zero.
template<std::size_t N>
std::string textOf(const char (&field)[N])
{
    return std::string(field, std::find(field, field + N, '\0'));
}

std::vector<XrExtensionProperties>
extensionsOf(PFN_xrEnumerateInstanceExtensionProperties enumerate)
{
    std::vector<XrExtensionProperties> extensions;
    std::uint32_t count = 0;
    XrResult result = enumerate(nullptr, 0, &count, nullptr);
    if (XR_SUCCEEDED(result))
    {
        count = std::min(count, kMostExtensions);
        extensions.resize(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, 0});
        result = enumerate(nullptr, count, &count, extensions.data());
    }
    if (XR_FAILED(result))
        throw OpenXrError("the loader finds no OpenXR runtime (" + resultName(result) +
                              "); no hands. Install one, such as Monado, or name its manifest in "
                              "XR_RUNTIME_JSON",
                          false);
    extensions.resize(std::min<std::size_t>(count, extensions.size()));
    return extensions;
}

/// "a, b and c".
std::string listed(const std::vector<std::string>& names)
{
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i)
        text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
    return text;
}

} // namespace

std::string resultName(XrResult result)
{
#define MIDAIR_NAME(name, value)                                                                   \
    case name:                                                                                     \
        return #name;
    switch (result)
    {
        XR_LIST_ENUM_XrResult(MIDAIR_NAME) default : break;
    }
#undef MIDAIR_NAME
    return fmt::format("XrResult {}", static_cast<int>(result));
}

OpenXrInstance::OpenXrInstance(const std::string& loader)
{
    loadLibrary(loader);
    try
    {
        create();
        findSystem();
    }
    catch (...)
    {
        if (_functions.destroyInstance) _functions.destroyInstance(_instance);
        throw;
    }
}

OpenXrInstance::~OpenXrInstance()
{
    _functions.destroyInstance(_instance);
}

void OpenXrInstance::loadLibrary(const std::string& loader)
{
    // The library is never closed: runtimes leave threads behind that may still be in it.
    void* library = dlopen(loader.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library)
    {
        // NOLINTNEXTLINE(concurrency-mt-unsafe): the C library keeps one a thread
        const char* why = dlerror();
        throw OpenXrError("the loader can't be loaded (" + std::string(why ? why : loader) +
                              "); no hands. Install libopenxr-loader1 and an OpenXR runtime",
                          false);
    }
    _functions.getInstanceProcAddr =
        reinterpret_cast<PFN_xrGetInstanceProcAddr>(dlsym(library, "xrGetInstanceProcAddr"));
    if (!_functions.getInstanceProcAddr)
        throw OpenXrError(
            loader + " is no OpenXR loader (it has no xrGetInstanceProcAddr); no hands", false);
}

template<typename F>
void OpenXrInstance::load(const char* name, F& function) const
{
    PFN_xrVoidFunction found = nullptr;
    const XrResult result = _functions.getInstanceProcAddr(_instance, name, &found);
    if (XR_FAILED(result) || !found)
        throw OpenXrError(_runtime + " has no function " + name + " (" + resultName(result) +
                              "); no hands",
                          false);
    function = reinterpret_cast<F>(found);
}

void OpenXrInstance::create()
{
    PFN_xrEnumerateInstanceExtensionProperties enumerate = nullptr;
    PFN_xrCreateInstance createInstance = nullptr;
    load("xrEnumerateInstanceExtensionProperties", enumerate);
    load("xrCreateInstance", createInstance);
    const std::vector<XrExtensionProperties> offered = extensionsOf(enumerate);
    // The runtime's name is available only through an instance, so one is made with the extensions
    // that are there.
    std::vector<const char*> present;
    std::vector<std::string> missing;
    for (const char* name : kNeeded)
        if (std::any_of(offered.begin(),
                        offered.end(),
                        [name](const XrExtensionProperties& extension)
                        { return textOf(extension.extensionName) == name; }))
            present.push_back(name);
        else
            missing.emplace_back(name);

    XrInstanceCreateInfo info{};
    info.type = XR_TYPE_INSTANCE_CREATE_INFO;
    std::strcpy(info.applicationInfo.applicationName, "osgMidair");
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    info.enabledExtensionCount = static_cast<std::uint32_t>(present.size());
    info.enabledExtensionNames = present.data();
    const XrResult result = createInstance(&info, &_instance);
    if (result == XR_ERROR_LIMIT_REACHED)
        throw OpenXrError("this program has an OpenXR instance already, and the loader allows no "
                          "second one (XR_ERROR_LIMIT_REACHED); no hands. Set hands with "
                          "InjectedHands instead",
                          false);
    if (XR_FAILED(result))
        throw OpenXrError("the runtime can't be reached (xrCreateInstance: " + resultName(result) +
                              "); no hands. Is its service running?",
                          true);
    loadFunctions();
    if (!missing.empty())
        throw OpenXrError(_runtime + " has no " + listed(missing) +
                              "; no hands. They take a runtime with " +
                              listed({kNeeded.begin(), kNeeded.end()}) + ", such as Monado",
                          false);
    load("xrConvertTimespecTimeToTimeKHR", _functions.convertTimespecTimeToTime);
    load("xrCreateHandTrackerEXT", _functions.createHandTracker);
    load("xrDestroyHandTrackerEXT", _functions.destroyHandTracker);
    load("xrLocateHandJointsEXT", _functions.locateHandJoints);
}

void OpenXrInstance::loadFunctions()
{
    load("xrDestroyInstance", _functions.destroyInstance);
    load("xrGetInstanceProperties", _functions.getInstanceProperties);
    load("xrGetSystem", _functions.getSystem);
    load("xrGetSystemProperties", _functions.getSystemProperties);
    load("xrPollEvent", _functions.pollEvent);
    load("xrCreateSession", _functions.createSession);
    load("xrDestroySession", _functions.destroySession);
    load("xrBeginSession", _functions.beginSession);
    load("xrEndSession", _functions.endSession);
    load("xrEnumerateReferenceSpaces", _functions.enumerateReferenceSpaces);
    load("xrCreateReferenceSpace", _functions.createReferenceSpace);
    load("xrDestroySpace", _functions.destroySpace);

    XrInstanceProperties properties{};
    properties.type = XR_TYPE_INSTANCE_PROPERTIES;
    check(_functions.getInstanceProperties(_instance, &properties), "xrGetInstanceProperties");
    const XrVersion version = properties.runtimeVersion;
    _runtime = fmt::format("{} {}.{}.{}",
                           textOf(properties.runtimeName),
                           XR_VERSION_MAJOR(version),
                           XR_VERSION_MINOR(version),
                           XR_VERSION_PATCH(version));
}

void OpenXrInstance::findSystem()
{
    XrSystemGetInfo wanted{};
    wanted.type = XR_TYPE_SYSTEM_GET_INFO;
    wanted.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
    const XrResult result = _functions.getSystem(_instance, &wanted, &_system);
    if (result == XR_ERROR_FORM_FACTOR_UNAVAILABLE)
        throw OpenXrError(_runtime + " has no headset now (" + resultName(result) +
                              "); no hands until it is connected",
                          true);
    check(result, "xrGetSystem");

    XrSystemHandTrackingPropertiesEXT tracking{};
    tracking.type = XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT;
    XrSystemProperties properties{};
    properties.type = XR_TYPE_SYSTEM_PROPERTIES;
    properties.next = &tracking;
    check(_functions.getSystemProperties(_instance, _system, &properties), "xrGetSystemProperties");
    if (!tracking.supportsHandTracking)
        throw OpenXrError(_runtime + ": \"" + textOf(properties.systemName) +
                              "\" doesn't track hands; no hands. It takes a headset or camera "
                              "that does",
                          false);
}

void OpenXrInstance::check(XrResult result, const char* call) const
{
    if (XR_SUCCEEDED(result)) return;
    const bool lost = result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST;
    throw OpenXrError(_runtime + ": " + call + ": " + resultName(result) + "; no hands" +
                          (lost ? " until it is back" : ""),
                      lost);
}

XrTime OpenXrInstance::now() const
{
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    XrTime time = 0;
    check(_functions.convertTimespecTimeToTime(_instance, &now, &time),
          "xrConvertTimespecTimeToTimeKHR");
    return time;
}

} // namespace midair::bridge
