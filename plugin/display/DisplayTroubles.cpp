#include "plugin/display/DisplayTroubles.h"

#include "haptics/base/text/MessageLog.h"
#include "plugin/engine/SceneAccess.h"

#include <osg/ComputeBoundsVisitor>
#include <osg/Notify>

namespace osgMidair
{

using midair::base::Message;
using midair::base::MessageCode;

void DisplayTroubles::set(Of kind, std::string text)
{
    if (_now[kind] == text) return;
    _now[kind] = std::move(text);
    _isNew = true;
}

void DisplayTroubles::tellTo(const std::vector<osg::observer_ptr<HapticScene>>& scenes)
{
    if (!std::exchange(_isNew, false)) return;
    std::vector<Message> head;
    std::vector<Message> view;
    for (int kind = 0; kind < KINDS; ++kind)
    {
        const std::string& text = _now[static_cast<std::size_t>(kind)];
        if (text.empty()) continue;
        std::vector<Message>& all = kind == HEAD ? head : view;
        all.emplace_back(kind == HEAD ? MessageCode::DISPLAY_HEAD : MessageCode::DISPLAY_VIEW,
                         "display " + _display + ": " + text);
        if (scenes.empty() && _told[static_cast<std::size_t>(kind)] != text)
            OSG_WARN << "osgMidair: " << all.back().text << std::endl;
    }
    if (scenes.empty()) _told = _now;
    for (const osg::observer_ptr<HapticScene>& one : scenes)
    {
        osg::ref_ptr<HapticScene> scene;
        if (!one.lock(scene)) continue;
        HapticEngine& engine = SceneAccess::engine(*scene);
        engine.sayNow({MessageCode::DISPLAY_HEAD, 0, _display}, head);
        engine.sayNow({MessageCode::DISPLAY_VIEW, 0, _display}, view);
    }
}

std::vector<std::string> DisplayTroubles::texts() const
{
    std::vector<std::string> all;
    for (const std::string& text : _now)
        if (!text.empty()) all.push_back(text);
    return all;
}

osg::BoundingBoxd feltBox(const HapticScene& scene)
{
    osg::BoundingBoxd box;
    for (const FoundObject& found : scene.getFoundObjects())
    {
        osg::ref_ptr<osg::Node> node;
        if (!found.hasShape || !found.node.lock(node)) continue;
        osg::ComputeBoundsVisitor bounds;
        node->accept(bounds);
        const osg::BoundingBox& local = bounds.getBoundingBox();
        if (!local.valid()) continue;
        for (const osg::Matrixd& toWorld :
             node->getNumParents() > 0 ? node->getParent(0)->getWorldMatrices() : osg::MatrixList())
            for (unsigned int i = 0; i < 8; ++i)
                box.expandBy(osg::Vec3d(local.corner(i)) * toWorld);
    }
    return box;
}

} // namespace osgMidair
