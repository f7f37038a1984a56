#pragma once

#include "engine-bridge/heads/HeadSource.h"
#include "engine-bridge/tags/TagRig.h"

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace midair::bridge
{

/// The head that carries a camera, or whose eye is one, located by the tags that it sees: a thread
/// takes the camera's images as they come. Images from files are taken in turn, the last one
/// repeatedly.
class TagHead : public HeadSource
{
public:
    /// Throws base::InputError if the camera can't be opened or the build has no AprilTag.
    explicit TagHead(TagRig rig);
    ~TagHead() override;

    bool headAt(double time_s, Head& head) override;
    std::string status() const override;
    std::vector<std::string> takeMessages() override;

    /// An older image (s) gives no head.
    static constexpr double kStale_s = 0.2;

private:
    struct Inside;
    void run();

    const std::unique_ptr<Inside> _inside;
    std::atomic<bool> _isEnding{false};
    std::thread _thread; ///< the last member: it uses the others
};

} // namespace midair::bridge
