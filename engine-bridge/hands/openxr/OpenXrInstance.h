#pragma once

#include "haptics/base/InputError.h"

#include <ctime>
#include <string>

#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

namespace midair::bridge
{

/// Thrown when OpenXR gives no hands; what() says what is missing and what would be right.
class OpenXrError : public base::InputError
{
public:
    OpenXrError(const std::string& what, bool mayPass) :
        base::InputError("openxr: " + what),
        _mayPass(mayPass)
    {
    }

    /// Returns true if trying again may succeed (a headset may be switched on, a session was lost).
    bool mayPass() const { return _mayPass; }

private:
    bool _mayPass;
};

/// The OpenXR functions that hand tracking needs; valid as long as their instance.
struct OpenXrFunctions
{
    PFN_xrGetInstanceProcAddr getInstanceProcAddr = nullptr;
    PFN_xrDestroyInstance destroyInstance = nullptr;
    PFN_xrGetInstanceProperties getInstanceProperties = nullptr;
    PFN_xrGetSystem getSystem = nullptr;
    PFN_xrGetSystemProperties getSystemProperties = nullptr;
    PFN_xrPollEvent pollEvent = nullptr;
    PFN_xrCreateSession createSession = nullptr;
    PFN_xrDestroySession destroySession = nullptr;
    PFN_xrBeginSession beginSession = nullptr;
    PFN_xrEndSession endSession = nullptr;
    PFN_xrEnumerateReferenceSpaces enumerateReferenceSpaces = nullptr;
    PFN_xrCreateReferenceSpace createReferenceSpace = nullptr;
    PFN_xrDestroySpace destroySpace = nullptr;
    PFN_xrConvertTimespecTimeToTimeKHR convertTimespecTimeToTime = nullptr;
    PFN_xrCreateHandTrackerEXT createHandTracker = nullptr;
    PFN_xrDestroyHandTrackerEXT destroyHandTracker = nullptr;
    PFN_xrLocateHandJointsEXT locateHandJoints = nullptr;
};

/// An instance of a runtime that can track hands without rendering, and its headset; the
/// constructor loads the loader's library.
class OpenXrInstance
{
public:
    /// \a loader: file name of the loader's library. Throws OpenXrError.
    explicit OpenXrInstance(const std::string& loader);
    ~OpenXrInstance();
    OpenXrInstance(const OpenXrInstance&) = delete;
    OpenXrInstance& operator=(const OpenXrInstance&) = delete;

    const OpenXrFunctions& functions() const { return _functions; }
    XrInstance handle() const { return _instance; }
    XrSystemId system() const { return _system; }
    const std::string& runtime() const { return _runtime; } ///< name and version

    /// Throws OpenXrError if \a result, of the function \a call, is an error.
    void check(XrResult result, const char* call) const;

    /// The runtime's time now.
    XrTime now() const;

private:
    void loadLibrary(const std::string& loader);
    void create();
    void loadFunctions();
    void findSystem();
    template<typename F>
    void load(const char* name, F& function) const;

    OpenXrFunctions _functions;
    XrInstance _instance = XR_NULL_HANDLE;
    XrSystemId _system = XR_NULL_SYSTEM_ID;
    std::string _runtime = "the runtime";
};

/// "XR_ERROR_RUNTIME_FAILURE" and the like.
std::string resultName(XrResult result);

} // namespace midair::bridge
