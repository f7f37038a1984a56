#pragma once

#include <functional>
#include <memory>

namespace midair::samples
{

/// Threads that are waited for at the end, though not for ever: one that hangs is left behind. So
/// what they use must belong to them, too (std::shared_ptr).
class PatientThreads
{
public:
    PatientThreads();

    /// Starts a thread. What \a body throws ends that thread alone, and is told by \a name. Throws
    /// std::system_error if there is none left.
    void start(const char* name, std::function<void()> body);

    /// Waits until all have ended, for at most \a atMost_s, once they were told to. Returns false
    /// if some have not.
    bool finish(double atMost_s);

private:
    struct Count;

    std::shared_ptr<Count> _running;
};

} // namespace midair::samples
