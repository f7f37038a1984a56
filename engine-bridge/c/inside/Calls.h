#pragma once

#include "engine-bridge/c/midair.h"

#include <cstddef>
#include <exception>
#include <string>
#include <type_traits>
#include <utility>

namespace midair::capi
{

/// Why a call of the C interface fails, with the status that it returns.
class Failure : public std::exception
{
public:
    Failure(midair_status status, std::string text) : _status(status), _text(std::move(text)) {}

    midair_status status() const { return _status; }
    const char* what() const noexcept override { return _text.c_str(); }

private:
    midair_status _status;
    std::string _text;
};

/// Forgets this thread's last error.
void beginCall() noexcept;
/// To be called in a handler of all exceptions: keeps what was caught as this thread's last error,
/// and returns its status.
midair_status caught() noexcept;
/// Keeps why a call gave silence, and returns MIDAIR_SILENT.
midair_status silentFor(const std::string& why);

/// Runs the body of a function of the C interface, which returns its status, or nothing: then it is
/// MIDAIR_OK. No exception leaves.
template<typename Body>
midair_status called(const Body& body) noexcept
{
    beginCall();
    try
    {
        if constexpr (std::is_void_v<decltype(body())>)
        {
            body();
            return MIDAIR_OK;
        }
        else
            return body();
    }
    catch (...)
    {
        return caught();
    }
}

[[noreturn]] void fail(midair_status status, const std::string& text);

/// Returns what \a pointer points to; fails if it is null. \a name: of the argument.
template<typename T>
T& given(T* pointer, const char* name)
{
    if (!pointer) fail(MIDAIR_INVALID, std::string(name) + " is NULL");
    return *pointer;
}

/// Returns a text argument; fails if it is null or longer than \a most bytes.
std::string textGiven(const char* text, const char* name, std::size_t most = 1 << 16);

/// Fails unless all of \a count numbers are finite; \a each: numbers of one thing, for the message.
void requireFinite(const double* numbers,
                   std::size_t count,
                   const char* name,
                   std::size_t each = 1);

/// Writes \a text with its end into \a room of \a size bytes, and what it takes into \a needed,
/// which may be null. Fails with MIDAIR_TOO_SMALL; a size of 0 only asks.
midair_status writeText(const std::string& text, char* room, std::size_t size, std::size_t* needed);

/// While one exists, this thread runs a callback of the application's, which may not call functions
/// with a scene: it would wait for itself.
class CallbackScope
{
public:
    CallbackScope() noexcept;
    ~CallbackScope();
    CallbackScope(const CallbackScope&) = delete;
    CallbackScope& operator=(const CallbackScope&) = delete;

    static bool isInside() noexcept;
};

} // namespace midair::capi
