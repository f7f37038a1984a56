#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

/// Where fakes that hang wait while it is set; a test sets it and lets go. After a minute they go
/// on by themselves, so that a test fails rather than hangs.
class Halt
{
public:
    explicit Halt(bool isSet = false) : _isSet(isSet) {}

    Halt& operator=(bool isSet)
    {
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            _isSet = isSet;
        }
        _changed.notify_all();
        return *this;
    }
    void pass() const
    {
        std::unique_lock<std::mutex> lock(_mutex);
        _changed.wait_for(lock, std::chrono::minutes(1), [this] { return !_isSet; });
    }

private:
    mutable std::mutex _mutex;
    mutable std::condition_variable _changed;
    bool _isSet;
};
