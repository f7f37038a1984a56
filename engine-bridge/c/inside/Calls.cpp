#include "engine-bridge/c/inside/Calls.h"

#include "device/ArrayDevice.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/StopToken.h"

#include <cstring>
#include <new>

#include <fmt/format.h>

namespace midair::capi
{

namespace
{

/// The last error of a thread. Without memory for a text it uses a fixed one.
struct LastError
{
    std::string text;
    const char* fixed = nullptr;
};

LastError& lastError() noexcept
{
    thread_local LastError error;
    return error;
}

thread_local int callbacks = 0;

midair_status keep(midair_status status, const char* text) noexcept
{
    LastError& error = lastError();
    try
    {
        error.text = text;
        error.fixed = nullptr;
    }
    catch (...)
    {
        error.fixed = "there is no memory left";
    }
    return status;
}

} // namespace

void beginCall() noexcept
{
    lastError().text.clear();
    lastError().fixed = nullptr;
}

midair_status caught() noexcept
{
    try
    {
        throw;
    }
    catch (const Failure& failure)
    {
        return keep(failure.status(), failure.what());
    }
    catch (const base::Stopped& stopped)
    {
        return keep(MIDAIR_STOPPED, stopped.what());
    }
    catch (const base::InputError& error)
    {
        return keep(MIDAIR_REFUSED, error.what());
    }
    catch (const device::DeviceError& error)
    {
        return keep(MIDAIR_REFUSED, error.what());
    }
    catch (const std::bad_alloc&)
    {
        return keep(MIDAIR_NO_MEMORY, "there is no memory left");
    }
    catch (const std::exception& error)
    {
        return keep(MIDAIR_FAILED, error.what());
    }
    catch (...)
    {
        return keep(MIDAIR_FAILED, "something was thrown that is no std::exception");
    }
}

midair_status silentFor(const std::string& why)
{
    return keep(MIDAIR_SILENT, why.empty() ? "the field is silent" : why.c_str());
}

void fail(midair_status status, const std::string& text)
{
    throw Failure(status, text);
}

std::string textGiven(const char* text, const char* name, std::size_t most)
{
    given(text, name);
    const std::size_t length = strnlen(text, most + 1);
    if (length > most)
        fail(MIDAIR_INVALID,
             fmt::format("{} is longer than {} bytes, which is the most", name, most));
    return {text, length};
}

void requireFinite(const double* numbers, std::size_t count, const char* name, std::size_t each)
{
    for (std::size_t i = 0; i < count; ++i)
        if (!std::isfinite(numbers[i]))
            fail(MIDAIR_INVALID,
                 fmt::format("{}: number {} of the {}. is {}; all must be finite",
                             name,
                             i % each + 1,
                             i / each + 1,
                             numbers[i]));
}

midair_status writeText(const std::string& text, char* room, std::size_t size, std::size_t* needed)
{
    if (needed) *needed = text.size() + 1;
    if (size == 0 && needed) return MIDAIR_OK;
    given(room, "text");
    if (size <= text.size())
        fail(MIDAIR_TOO_SMALL,
             fmt::format("the text takes {} bytes, there are {}", text.size() + 1, size));
    std::memcpy(room, text.c_str(), text.size() + 1);
    return MIDAIR_OK;
}

CallbackScope::CallbackScope() noexcept
{
    ++callbacks;
}

CallbackScope::~CallbackScope()
{
    --callbacks;
}

bool CallbackScope::isInside() noexcept
{
    return callbacks > 0;
}

} // namespace midair::capi

uint32_t midair_version(void)
{
    return MIDAIR_VERSION;
}

const char* midair_status_name(midair_status status)
{
    switch (status)
    {
    case MIDAIR_OK:
        return "ok";
    case MIDAIR_SILENT:
        return "silent";
    case MIDAIR_INVALID:
        return "invalid";
    case MIDAIR_CLOSED:
        return "closed";
    case MIDAIR_UNKNOWN:
        return "unknown";
    case MIDAIR_REFUSED:
        return "refused";
    case MIDAIR_TOO_SMALL:
        return "too small";
    case MIDAIR_NOT_YET:
        return "not yet";
    case MIDAIR_STOPPED:
        return "stopped";
    case MIDAIR_SILENCED:
        return "silenced";
    case MIDAIR_NO_MEMORY:
        return "no memory";
    case MIDAIR_FAILED:
        return "failed";
    default:
        return "unknown status";
    }
}

const char* midair_last_error(void)
{
    const auto& error = midair::capi::lastError();
    return error.fixed ? error.fixed : error.text.c_str();
}
