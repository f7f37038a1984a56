#pragma once

#include "engine-bridge/c/inside/Calls.h"
#include "haptics/base/ThrownBy.h"

#include <array>
#include <string>

namespace midair::capi
{

/// An open source of the application (Callbacks: midair_hand_source, midair_head_source).
template<typename Callbacks>
class OwnSource
{
public:
    /// Fails if it can't be opened.
    OwnSource(const Callbacks& callbacks, const std::string& options) : _callbacks(callbacks)
    {
        const CallbackScope inside;
        std::array<char, 1024> error{};
        const std::string thrown = base::thrownBy(
            [&] {
                _instance = _callbacks.open(
                    _callbacks.user, options.c_str(), error.data(), error.size() - 1);
            });
        if (!thrown.empty()) fail(MIDAIR_REFUSED, "its open() has thrown " + thrown);
        if (!_instance)
            fail(MIDAIR_REFUSED,
                 error.front() ? std::string(error.data()) : "its open() returned NULL");
    }
    ~OwnSource()
    {
        const CallbackScope inside;
        if (_callbacks.close) base::thrownBy([&] { _callbacks.close(_instance); });
    }
    OwnSource(const OwnSource&) = delete;
    OwnSource& operator=(const OwnSource&) = delete;

    const Callbacks& callbacks() const { return _callbacks; }
    void* instance() const { return _instance; }

private:
    const Callbacks _callbacks;
    void* _instance = nullptr;
};

} // namespace midair::capi
