#pragma once

#include <osg/Notify>

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace midair::samples
{

/// Passes on what the kit and OpenSceneGraph say, on any thread, and counts lines that say the same
/// twice within a second: of these an exhibition's journal would be full.
class SaidLines : public osg::NotifyHandler
{
public:
    void notify(osg::NotifySeverity severity, const char* message) override;

    std::uint64_t count() const;
    /// Returns lines, without their numbers, that came more than once a second, and how often at
    /// the most.
    std::map<std::string, std::uint64_t> tooOften() const;

private:
    mutable std::mutex _mutex;
    std::uint64_t _count = 0;
    std::chrono::steady_clock::time_point _begin; ///< of the second that is counted in
    std::map<std::string, std::uint64_t> _second;
    std::map<std::string, std::uint64_t> _tooOften;
};

} // namespace midair::samples
