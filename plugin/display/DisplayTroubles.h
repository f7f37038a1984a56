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

/// What is wrong with a display now. It is told to the scenes that it shows, as their messages
/// `display.head` and `display.view`; to osg::notify() as long as there is none.
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

    /// An empty \a text: nothing is wrong any more.
    void set(Of kind, std::string text);
    void tellTo(const std::vector<osg::observer_ptr<HapticScene>>& scenes);
    std::vector<std::string> texts() const;

private:
    const std::string _display;
    std::array<std::string, KINDS> _now;
    std::array<std::string, KINDS> _told; ///< when there was no scene
    bool _isNew = false;                  ///< since it was told to scenes
    std::size_t _scenes = 0;              ///< that it was told to
};

/// The box in the world around all that can be felt of \a scene, in its units.
osg::BoundingBoxd feltBox(const HapticScene& scene);

} // namespace osgMidair
