#pragma once

#include <osg/ref_ptr>

#include <vector>

namespace osgViewer
{
class ViewerBase;
}

namespace osgMidair
{

class HapticEngine;

/// An engine's place among those that are played as one: joined scenes that a viewer shows beside
/// each other and that ask for the same array. The one that is first here plays for the others.
class JoinedScene
{
public:
    /// Joins nothing before setJoined(true).
    explicit JoinedScene(HapticEngine& engine);
    ~JoinedScene();
    JoinedScene(const JoinedScene&) = delete;
    JoinedScene& operator=(const JoinedScene&) = delete;

    /// From any thread.
    void setJoined(bool joined);
    bool isJoined() const;
    /// Notes the viewer that shows the scene; the last one counts.
    void follow(const osgViewer::ViewerBase& viewer);

    /// Returns the engine that plays this one's scene; null: itself. On the update thread.
    osg::ref_ptr<HapticEngine> host() const;
    /// Puts the engines whose host this one is into \a guests. On the update thread.
    void findGuests(std::vector<osg::ref_ptr<HapticEngine>>& guests) const;

private:
    HapticEngine& _engine;
};

} // namespace osgMidair
