#include "samples/tools/display/ScreenSigns.h"

#include "engine-bridge/display/DisplayFit.h"
#include "engine-bridge/tags/TagFit.h"
#include "haptics/base/InputError.h"
#include "samples/shared/views/Offscreen.h"

#include <osg/Geometry>
#include <osg/LineWidth>
#include <osgDB/WriteFile>

namespace midair::samples
{

namespace
{

const osg::Vec4 kShownSign(1.0F, 1.0F, 1.0F, 1.0F);
const osg::Vec4 kDimSign(0.16F, 0.16F, 0.16F, 1.0F);
constexpr float kSignWidth_px = 3.0F;

/// Returns a cross at \a x, \a y with arms of \a arm pixels.
osg::ref_ptr<osg::Geometry> crossAt(float x, float y, float arm, const osg::Vec4& color)
{
    const osg::ref_ptr<osg::Geometry> cross = new osg::Geometry;
    const osg::ref_ptr<osg::Vec3Array> ends = new osg::Vec3Array;
    for (const osg::Vec3& end : {osg::Vec3(x - arm, y, 0.0F),
                                 osg::Vec3(x + arm, y, 0.0F),
                                 osg::Vec3(x, y - arm, 0.0F),
                                 osg::Vec3(x, y + arm, 0.0F)})
        ends->push_back(end);
    const osg::ref_ptr<osg::Vec4Array> colors = new osg::Vec4Array;
    colors->push_back(color);
    cross->setVertexArray(ends);
    cross->setColorArray(colors, osg::Array::BIND_OVERALL);
    cross->addPrimitiveSet(new osg::DrawArrays(GL_LINES, 0, 4));
    cross->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(kSignWidth_px));
    cross->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    return cross;
}

} // namespace

ScreenSigns::ScreenSigns(const bridge::Display& display) :
    _display(display),
    _width(display.width),
    _height(display.height)
{
    _signs->setDataVariance(osg::Object::DYNAMIC);
}

void ScreenSigns::showCross(int index)
{
    _signs->removeChildren(0, _signs->getNumChildren());
    const auto& crosses = bridge::displayCrosses();
    const auto arm = static_cast<float>(_height) / 24.0F;
    for (std::size_t k = 0; k < crosses.size(); ++k)
    {
        const bool isAsked = static_cast<int>(k) == index;
        _signs->addChild(crossAt(static_cast<float>(crosses[k].x() * _width),
                                 static_cast<float>(crosses[k].y() * _height),
                                 isAsked ? arm : 0.4F * arm,
                                 isAsked ? kShownSign : kDimSign));
    }
}

void ScreenSigns::showTags()
{
    _signs->removeChildren(0, _signs->getNumChildren());
    const bridge::TagDetector detector;
    const osg::ref_ptr<osg::Geometry> squares = new osg::Geometry;
    const osg::ref_ptr<osg::Vec3Array> corners = new osg::Vec3Array;
    for (const bridge::ShownTag& tag : bridge::shownTags(_display))
    {
        const bridge::GrayImage bitmap = detector.bitmap(tag.id);
        const Eigen::Vector2d right =
            (tag.corners[1] - tag.corners[0]) / bridge::TagDetector::kSquares;
        const Eigen::Vector2d up =
            (tag.corners[3] - tag.corners[0]) / bridge::TagDetector::kSquares;
        const auto add = [&](double i, double j)
        {
            const Eigen::Vector2d at = tag.corners[3] + i * right - j * up;
            corners->push_back(osg::Vec3(
                static_cast<float>(at.x() * _width), static_cast<float>(at.y() * _height), 0.0F));
        };
        // Draws the white squares on the black screen. The tag's black border begins at the second
        // square.
        for (int j = 0; j < bitmap.height; ++j)
            for (int i = 0; i < bitmap.width; ++i)
            {
                if (bitmap.pixels[static_cast<std::size_t>(j * bitmap.width + i)] < 128) continue;
                add(i - 1.0, j - 1.0);
                add(i, j - 1.0);
                add(i, j);
                add(i - 1.0, j);
            }
    }
    const osg::ref_ptr<osg::Vec4Array> colors = new osg::Vec4Array;
    colors->push_back(kShownSign);
    squares->setVertexArray(corners);
    squares->setColorArray(colors, osg::Array::BIND_OVERALL);
    squares->addPrimitiveSet(new osg::DrawArrays(GL_QUADS, 0, static_cast<int>(corners->size())));
    squares->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    squares->getOrCreateStateSet()->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
    _signs->addChild(squares);
}

void ScreenSigns::openWindow(int number)
{
    if (!haveDisplay())
        throw base::InputError("can't open a window: DISPLAY is not set; --headless uses a "
                               "recording's touches without a window");
    _viewer = new osgViewer::Viewer;
    _viewer->setUpViewOnSingleScreen(static_cast<unsigned int>(number));
    osg::Camera& camera = *_viewer->getCamera();
    camera.setClearColor(osg::Vec4(0.0F, 0.0F, 0.0F, 1.0F));
    camera.setViewMatrix(osg::Matrix::identity());
    camera.setProjectionResizePolicy(osg::Camera::FIXED);
    camera.setProjectionMatrixAsOrtho2D(0.0, _width, 0.0, _height);
    camera.setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
    _viewer->setLightingMode(osg::View::NO_LIGHT);
    _viewer->setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
    _viewer->setSceneData(_signs);
    _viewer->realize();
}

bool ScreenSigns::frame()
{
    if (!_viewer) return true;
    if (_viewer->done()) return false;
    _viewer->frame();
    return true;
}

void ScreenSigns::save(const std::string& path) const
{
    std::string error;
    const osg::ref_ptr<osg::Image> image =
        renderFlat(*_signs, _width, _height, osg::Vec4(0.0F, 0.0F, 0.0F, 1.0F), &error);
    if (!image) throw base::InputError("no picture: " + error);
    if (!osgDB::writeImageFile(*image, path))
        throw base::InputError("can't write the picture to \"" + path + "\"");
}

} // namespace midair::samples
