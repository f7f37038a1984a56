#pragma once

#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>
#include <osgMidair/Hud>

#include <osg/BoundingBox>
#include <osgDB/WriteFile>
#include <osgViewer/Viewer>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

/// The picture of a sample in the guides; nothing that a feature needs. It is made if
/// MIDAIR_PICTURE=FILE,SECONDS,OVERLAY,.. asks for it, with an X display: the scene at that time,
/// or at its end, with these overlays.
class Picture
{
public:
    explicit Picture(osgMidair::HapticScene& scene) : _scene(&scene)
    {
        const char* const asked = std::getenv("MIDAIR_PICTURE");
        std::istringstream words(asked ? asked : "");
        std::string word;
        if (!std::getline(words, _file, ',') || !std::getline(words, word, ',')) return;
        _time_s = std::atof(word.c_str());
        std::vector<std::string> shown;
        while (std::getline(words, word, ','))
            shown.push_back(word);
        _overlays = new osgMidair::HapticOverlays;
        _overlays->showOnly(shown);
        _overlays->get<osgMidair::Hud>()->setKeyTime(0.0); // else they are listed
        _bound = scene.getBound();
        scene.addChild(_overlays);
        open();
    }
    ~Picture()
    {
        if (_viewer && _image->valid()) osgDB::writeImageFile(*_image, _file);
    }

    /// Returns true if a picture was asked for.
    bool isWanted() const { return _viewer.valid(); }
    /// Draws one of eight frames; the last one until the picture's time is the picture.
    void draw(osg::FrameStamp& stamp)
    {
        if (!_viewer || stamp.getSimulationTime() > _time_s || stamp.getFrameNumber() % 8) return;
        aim();
        _viewer->setFrameStamp(&stamp);
        _viewer->renderingTraversals();
    }

private:
    void open()
    {
        const osg::ref_ptr<osg::GraphicsContext::Traits> traits = new osg::GraphicsContext::Traits;
        traits->readDISPLAY();
        traits->width = 640;
        traits->height = 480;
        traits->pbuffer = true;
        const osg::ref_ptr<osg::GraphicsContext> context =
            osg::GraphicsContext::createGraphicsContext(traits);
        if (!context) return; // there is no display
        _viewer = new osgViewer::Viewer;
        osg::Camera& camera = *_viewer->getCamera();
        camera.setGraphicsContext(context);
        camera.setViewport(0, 0, traits->width, traits->height);
        camera.setProjectionMatrixAsPerspective(30.0, 4.0 / 3.0, 0.01, 100.0);
        camera.setClearColor(osg::Vec4(0.052F, 0.06F, 0.078F, 1.0F));
        camera.attach(osg::Camera::COLOR_BUFFER, _image);
        _viewer->setThreadingModel(osgViewer::Viewer::SingleThreaded);
        _viewer->setSceneData(_scene);
        _viewer->realize();
    }

    /// Looks at the objects, or else at the points, and at the array where that is shown.
    void aim()
    {
        osg::BoundingSphere seen = _bound;
        if (const osg::ref_ptr<const osgMidair::HapticField> field = _scene->getField())
        {
            const osg::Matrixd toWorld = osg::Matrixd::inverse(field->getWorldToArray());
            osg::BoundingBox box;
            for (const osgMidair::HapticField::ControlPoint& point : field->getPoints())
                if (!_bound.valid()) box.expandBy(point.position);
            if (_overlays->isShown("array") && field->getArray())
                for (const osgMidair::Transducer& each : field->getArray()->transducers)
                    box.expandBy(each.position * toWorld);
            seen.expandBy(box);
        }
        const double room = _overlays->isShown("hands") ? 6.0 : 4.0; // times the radius
        osg::Vec3d towards(0.45, -1.0, 0.55);
        towards.normalize();
        const osg::Vec3d eye = towards * (room * std::max<double>(seen.radius(), 0.04));
        _viewer->getCamera()->setViewMatrixAsLookAt(
            seen.center() + eye, seen.center(), osg::Z_AXIS);
    }

    osg::ref_ptr<osgMidair::HapticScene> _scene;
    osg::ref_ptr<osgMidair::HapticOverlays> _overlays;
    osg::ref_ptr<osgViewer::Viewer> _viewer;
    osg::ref_ptr<osg::Image> _image = new osg::Image;
    osg::BoundingSphere _bound;
    std::string _file;
    double _time_s = 0.0;
};
