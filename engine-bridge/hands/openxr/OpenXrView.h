#pragma once

#include "engine-bridge/hands/openxr/OpenXrTracker.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// A current GLX context, as returned by GLX.
struct OpenXrGraphics
{
    void* display = nullptr; ///< Display*
    std::uint32_t visual = 0;
    void* config = nullptr; ///< GLXFBConfig
    unsigned long drawable = 0;
    void* context = nullptr; ///< GLXContext
};

/// Position and field of view of an eye at display time.
struct OpenXrEye
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< to the runtime's space, m
    /// Tangents of the angles of its field of view; left and down are usually below 0.
    double left = -1.0;
    double right = 1.0;
    double down = -1.0;
    double up = 1.0;
};

using OpenXrEyes = std::array<OpenXrEye, 2>; ///< left, right

/// Background behind the drawn picture.
enum class OpenXrBlend
{
    OPAQUE,   ///< nothing
    ADDITIVE, ///< the room, with light added
    ALPHA     ///< the room where alpha is 0
};

/// The picture in a headset: session, swapchains and frames. It lends its session to all trackers.
/// For the thread that draws.
class OpenXrView
{
public:
    /// Finds a headset. \a anchor: a place in the runtime's space at which the space is anchored to
    /// the room, if the runtime has anchors. Throws base::InputError, with the reason, if there is
    /// none.
    OpenXrView(const OpenXrOptions& options, const Eigen::Isometry3d& anchor);
    ~OpenXrView(); ///< needs the context of begin() if hasSession()
    OpenXrView(const OpenXrView&) = delete;
    OpenXrView& operator=(const OpenXrView&) = delete;

    /// Begins a session in \a graphics, whose context is current. Throws base::InputError. After
    /// end() a new one can begin.
    void begin(const OpenXrGraphics& graphics);
    /// Ends the session; its context must be current.
    void end();
    bool hasSession() const;

    /// Handles the runtime's events and waits until it wants a frame. Returns false if it wants
    /// none because the session doesn't run. Throws base::InputError once the session is over;
    /// mayReturn() tells whether another can begin.
    bool wait();
    bool mayReturn() const;
    /// Returns the display time of the frame of wait(), s on the steady clock; none if the runtime
    /// doesn't report it.
    std::optional<double> displayTime() const;
    /// Locates the eyes at the frame's display time. Returns false if they are unknown, or if the
    /// frame isn't visible.
    bool locate(OpenXrEyes& eyes);
    void beginFrame();
    /// \{ Textures for drawing the eye's picture, between beginFrame() and endFrame(). depth() is 0
    /// if the runtime accepts none.
    std::uint32_t picture(int eye);
    std::uint32_t depth(int eye);
    /// \}
    /// Submits both pictures; without them an empty frame. \a near_m, \a far_m: the clip planes.
    void endFrame(double near_m, double far_m);

    int width(int eye) const;
    int height(int eye) const;
    int depthFormat() const; ///< of depth(), as numbered by OpenGL; 0: not accepted
    OpenXrBlend blend() const;
    bool takeMute(); ///< true if the controller's button was pressed since the last call
    std::string runtime() const;
    /// One line of text: the present state.
    std::string status() const;
    /// Messages from number \a told on.
    std::vector<std::string> messages(std::size_t& told) const;

private:
    class Inside;

    const std::unique_ptr<Inside> _inside;
};

} // namespace midair::bridge
