#include "plugin/overlays/hud/HudRoom.h"

#include <osg/Camera>
#include <osg/Geometry>
#include <osgUtil/CullVisitor>
#include <osgViewer/View>
#include <osgViewer/ViewerEventHandlers>

#include <algorithm>
#include <cmath>
#include <vector>

namespace osgMidair
{

namespace
{

/// Position of the frame rate's line, which has no background, in units of the display, which is
/// 1024 high.
constexpr float kFirstLine = 965.0F;
constexpr float kTop = 1024.0F;
/// A block at least this fraction of the viewport wide leaves no room beside it.
constexpr float kWide = 0.6F;

/// Collects the backgrounds of the statistics. Ignores texts and geometries with callbacks, which
/// change while another thread draws.
class Backgrounds : public osg::NodeVisitor
{
public:
    Backgrounds() : osg::NodeVisitor(TRAVERSE_ACTIVE_CHILDREN) {}

    void apply(osg::Drawable& drawable) override
    {
        const osg::Geometry* geometry = drawable.asGeometry();
        if (!geometry || geometry->getDrawCallback()) return;
        const auto* vertices = dynamic_cast<const osg::Vec3Array*>(geometry->getVertexArray());
        if (!vertices) return;
        osg::BoundingBox box;
        for (const osg::Vec3& vertex : *vertices)
            box.expandBy(vertex);
        if (box.valid()) boxes.push_back(box);
    }

    std::vector<osg::BoundingBox> boxes;
};

/// Returns the camera of the statistics over the window of \a camera; null: none.
const osg::Camera* statisticsOver(osg::Camera& camera)
{
    auto* view = dynamic_cast<osgViewer::View*>(camera.getView());
    if (!view || !view->getViewerBase()) return nullptr;
    osgViewer::ViewerBase::Views views;
    view->getViewerBase()->getViews(views);
    for (osgViewer::View* each : views)
        for (const auto& handler : each->getEventHandlers())
        {
            auto* display = dynamic_cast<osgViewer::StatsHandler*>(handler.get());
            const osg::Camera* found = display ? display->getCamera() : nullptr;
            if (found && found->getNodeMask() != 0 && found->getNumChildren() > 0 &&
                found->getViewport() && found->getGraphicsContext() == camera.getGraphicsContext())
                return found;
        }
    return nullptr;
}

/// Removes \a box, of the statistics' \a camera, from \a room of the viewport \a own.
void keepClear(const osg::BoundingBox& box,
               const osg::Camera& camera,
               const osg::Viewport& own,
               bool wideOnes,
               HudRoom& room)
{
    const osg::Matrixd& projection = camera.getProjectionMatrix();
    const osg::Viewport& viewport = *camera.getViewport();
    const auto place = [&](const osg::Vec3& vertex)
    {
        const osg::Vec3d seen = osg::Vec3d(vertex) * projection;
        const double x = viewport.x() + 0.5 * (seen.x() + 1.0) * viewport.width() - own.x();
        const double y = viewport.y() + 0.5 * (seen.y() + 1.0) * viewport.height() - own.y();
        return osg::Vec2(static_cast<float>(x / room.scale), static_cast<float>(y / room.scale));
    };
    const osg::Vec2 low = place(box._min);
    const osg::Vec2 high = place(box._max);
    const bool isWide = high.x() - low.x() >= kWide * room.viewport.x();
    const bool isInside = low.y() < room.upperRight.y() && high.y() > 0.0F &&
                          low.x() < room.upperRight.x() && high.x() > 0.0F;
    if (isWide != wideOnes || !isInside) return;
    if (isWide)
        room.upperRight.y() = std::clamp(low.y(), 0.0F, room.upperRight.y());
    else
        room.lowerLeft.x() = std::clamp(high.x(), room.lowerLeft.x(), room.upperRight.x());
}

} // namespace

double hudScale(double width, double height)
{
    return std::max(1.0, 0.5 * std::floor(std::min(height, 0.75 * width) / 350.0));
}

double labelScale(double width, double height)
{
    return std::max(1.0, std::min(height, 0.75 * width) / 560.0);
}

const WorldSheet* WorldSheet::of(const osg::Camera* camera)
{
    return camera ? dynamic_cast<const WorldSheet*>(camera->getUserData()) : nullptr;
}

HudRoom roomOf(osgUtil::CullVisitor& visitor, double scale, float top)
{
    HudRoom room;
    const auto leaveTop = [&room, top]
    {
        room.top = top * room.viewport.y();
        room.upperRight = room.viewport - osg::Vec2(0.0F, room.top);
    };
    if (const WorldSheet* sheet = WorldSheet::of(visitor.getCurrentCamera()))
    {
        room.viewport = sheet->size;
        leaveTop();
        return room;
    }
    const osg::Viewport* viewport = visitor.getViewport();
    if (!viewport) return room;
    room.scale = scale > 0.0 ? scale : hudScale(viewport->width(), viewport->height());
    room.viewport.set(static_cast<float>(viewport->width() / room.scale),
                      static_cast<float>(viewport->height() / room.scale));
    leaveTop();
    osg::Camera* camera = visitor.getCurrentCamera();
    const osg::Camera* statistics = camera ? statisticsOver(*camera) : nullptr;
    if (!statistics) return room;
    Backgrounds backgrounds;
    for (unsigned int i = 0; i < statistics->getNumChildren(); ++i)
        const_cast<osg::Node*>(statistics->getChild(i))->accept(backgrounds);
    const float whole = static_cast<float>(2.0 / statistics->getProjectionMatrix()(0, 0));
    backgrounds.boxes.emplace_back(0.0F, kFirstLine, 0.0F, whole, kTop, 0.0F);
    for (const bool wideOnes : {true, false})
        for (const osg::BoundingBox& box : backgrounds.boxes)
            keepClear(box, *statistics, *viewport, wideOnes, room);
    return room;
}

} // namespace osgMidair
