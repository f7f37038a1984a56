#include "plugin/overlays/HidingHands.h"

#include "engine-bridge/hands/Hand.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/HandGeometry.h"

#include <osg/NodeVisitor>

#include <cmath>

namespace osgMidair
{

namespace
{

/// Collects the outermost nodes whose scene is played.
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
    camera.addChild(_group); // also after the camera was given another scene
    osg::StateSet* state = camera.getOrCreateStateSet();
    if (!state->getUniform(kHandsHide))
        state->addUniform(new osg::Uniform(kHandsHide, 1.0F),
                          osg::StateAttribute::ON | osg::StateAttribute::OVERRIDE);
}

void HidingHands::update(osg::Node& root)
{
    if (_root != &root || _scenes.empty())
    {
        _root = &root;
        _scenes.clear();
        _group->removeChildren(0, _group->getNumChildren());
        for (const osg::observer_ptr<osg::Node>& node : PlayedNodes(root).found)
        {
            const osg::ref_ptr<osg::MatrixTransform> frame = new osg::MatrixTransform;
            frame->setDataVariance(osg::Object::DYNAMIC);
            const osg::ref_ptr<HandsOverlay> hands = new HandsOverlay;
            hands->setOcclude(true);
            frame->addChild(hands);
            _group->addChild(frame);
            _scenes.emplace_back(node, frame);
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
            midair::bridge::handCapsules(tracker.frame()), {}, tracker.frame().time_s);
    }
}

} // namespace osgMidair
