#include "plugin/overlays/HidingHands.h"

#include "engine-bridge/hands/Hand.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/HandGeometry.h"

#include <osg/NodeVisitor>

#include <algorithm>
#include <cmath>

namespace osgMidair
{

namespace
{

/// Collects the outermost nodes with a played scene.
class PlayedNodes : public osg::NodeVisitor
{
public:
    explicit PlayedNodes(osg::Node& root) : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN)
    {
        root.accept(*this);
    }
    void apply(osg::Node& node) override
    {
        if (SceneAccess::playing({&node}))
            found.emplace_back(&node);
        else
            traverse(node);
    }

    std::vector<osg::observer_ptr<osg::Node>> found;
};

} // namespace

HidingHands::HidingHands() : _group(new osg::Group)
{
    _group->setName("hands that hide");
    _group->setCullingActive(false);
}

void HidingHands::drawIn(osg::Camera& camera) const
{
    if (camera.containsNode(_group)) return;
    camera.addChild(_group); // also after the camera got another scene
    osg::StateSet* state = camera.getOrCreateStateSet();
    if (!state->getUniform(kHandsHide))
        state->addUniform(new osg::Uniform(kHandsHide, 1.0F),
                          osg::StateAttribute::ON | osg::StateAttribute::OVERRIDE);
}

void HidingHands::follow(const osg::observer_ptr<osg::Node>& node)
{
    const osg::ref_ptr<osg::MatrixTransform> frame = new osg::MatrixTransform;
    frame->setDataVariance(osg::Object::DYNAMIC);
    const osg::ref_ptr<HandsOverlay> hands = new HandsOverlay;
    hands->setOcclude(true);
    frame->addChild(hands);
    _group->addChild(frame);
    _scenes.emplace_back(node, frame);
}

void HidingHands::update(osg::Node& root, double now_s)
{
    if (_root != &root || now_s - _looked_s >= kLookAgain_s)
    {
        _root = &root;
        _looked_s = now_s;
        const std::vector<osg::observer_ptr<osg::Node>> found = PlayedNodes(root).found;
        const bool isSame =
            std::equal(found.begin(),
                       found.end(),
                       _scenes.begin(),
                       _scenes.end(),
                       [](const auto& node, const auto& scene) { return node == scene.first; });
        if (!isSame)
        {
            _scenes.clear();
            _group->removeChildren(0, _group->getNumChildren());
            for (const osg::observer_ptr<osg::Node>& node : found)
                follow(node);
        }
    }
    for (const auto& [node, frame] : _scenes)
    {
        osg::ref_ptr<osg::Node> played;
        const osg::ref_ptr<HapticEngine> engine =
            node.lock(played) ? SceneAccess::playing({played.get()}) : nullptr;
        auto& hands = static_cast<HandsOverlay&>(*frame->getChild(0));
        if (!engine)
        {
            OverlayPart::of(hands).setHands({}, {}, 0.0);
            continue;
        }
        const HapticSettings& settings = engine->settings();
        const double unitsPerMetre = 1.0 / settings.metresPerUnit;
        if (unitsPerMetre > 0.0 && std::isfinite(unitsPerMetre))
            frame->setMatrix(osg::Matrix::inverse(settings.calibration) *
                             osg::Matrix::scale(unitsPerMetre, unitsPerMetre, unitsPerMetre));
        const midair::bridge::HandTracker& tracker = engine->hands();
        OverlayPart::of(hands).setHands(
            midair::bridge::handCapsules(tracker.shown()), {}, tracker.frame().time_s);
    }
}

} // namespace osgMidair
