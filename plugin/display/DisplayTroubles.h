#pragma once

#include <osgMidair/HapticScene>

#include <osg/BoundingBox>
#include <osg/observer_ptr>

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace osgMidair
{

/// The present problems of a display. They are reported to the scenes that it shows, as their
/// messages `display.head` and `display.view`; without a scene to osg::notify().
class DisplayTroubles
{
public:
    enum Of
    {
        HEAD,
        EYE,
        SHARE,
        WINDOW,
        STEREO,
        MANIPULATOR,
        KINDS
    };

    explicit DisplayTroubles(std::string display) : _display(std::move(display)) {}

    /// An empty \a text: the problem is solved.
    void set(Of kind, std::string text);
    /// Call it when the scenes have changed.
    void tellAgain() { _isNew = true; }
    void tellTo(const std::vector<osg::observer_ptr<HapticScene>>& scenes);
    std::vector<std::string> texts() const;

private:
    const std::string _display;
    std::array<std::string, KINDS> _now;
    std::array<std::string, KINDS> _told; ///< reported without a scene
    bool _isNew = false;                  ///< since the last report
};

/// The box in the world around all haptic objects of \a scene, in its units.
osg::BoundingBoxd feltBox(const HapticScene& scene);

} // namespace osgMidair
