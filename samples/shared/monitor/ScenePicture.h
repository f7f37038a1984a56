#pragma once

#include "samples/shared/monitor/MonitorSource.h"

#include <osg/Camera>

#include <memory>
#include <string>

namespace midair::samples
{

/// Pictures of what a camera draws, about 640 pixels wide, as JPEG. The thread that draws asks for
/// the pixels and fetches them some frames later, when they are there, so that it doesn't wait for
/// the graphics card; making the JPEG is done by whoever asks for it.
class ScenePicture : public PictureSource
{
public:
    static constexpr double kInterval_s = 0.5; ///< shortest time between two pictures
    static constexpr double kAsked_s = 3.0;    ///< for so long pictures are taken once asked for

    ScenePicture();
    ~ScenePicture() override;

    /// Adds the draw callback to \a camera.
    void show(osg::Camera& camera);
    void showNothing(const std::string& why);
    /// From now on nothing is taken.
    void end();

    MonitorPicture newest() override;
    PictureCost cost() const override;

private:
    struct Shared;
    class Readback;

    std::shared_ptr<Shared> _shared;
};

} // namespace midair::samples
