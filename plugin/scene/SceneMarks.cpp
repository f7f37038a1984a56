#include "plugin/scene/SceneMarks.h"

#include "engine-bridge/scene/GeometryReader.h"
#include "plugin/scene/CollectHapticSurfacesVisitor.h"

#include <osgMidair/HapticPoints>
#include <osgMidair/HapticSurface>

#include <osg/Drawable>
#include <osg/Group>
#include <osg/NodeVisitor>
#include <osg/PagedLOD>
#include <osg/Projection>
#include <osg/ProxyNode>
#include <osg/Transform>

#include <algorithm>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

// Files are loaded in order, each as the child with its number.
template<typename Loader>
std::string firstMissing(const Loader& loader)
{
    for (unsigned int i = loader.getNumChildren(); i < loader.getNumFileNames(); ++i)
        if (!loader.getFileName(i).empty()) return loader.getFileName(i);
    return {};
}

bool isMark(const osg::Node& node)
{
    return dynamic_cast<const HapticSurface*>(&node) || dynamic_cast<const HapticPoints*>(&node) ||
           hasHapticTag(node);
}

// Tags request the event traversal, and OSG counts such requests up to the root, hidden or not.
bool hasMark(const osg::Node& node)
{
    if (node.getNumChildrenRequiringEventTraversal() == 0) return false;
    if (isMark(node)) return true;
    const osg::Group* group = node.asGroup();
    for (unsigned int i = 0; group && i < group->getNumChildren(); ++i)
        if (hasMark(*group->getChild(i))) return true;
    return false;
}

std::string findMissing(const osg::Node& node)
{
    const osg::Group* group = node.asGroup();
    if (!group) return {};
    std::string missing = missingFile(node);
    if (!missing.empty()) return midair::bridge::quoted(node) + " (" + missing + ")";
    for (unsigned int i = 0; missing.empty() && i < group->getNumChildren(); ++i)
        missing = findMissing(*group->getChild(i));
    return missing;
}

/// Reports the active children of one group, as the reader of its mesh meets them.
class ActiveChildren : public osg::NodeVisitor
{
public:
    explicit ActiveChildren(osg::Node& group) : osg::NodeVisitor(TRAVERSE_ACTIVE_CHILDREN)
    {
        group.traverse(*this);
    }
    void apply(osg::Node& node) override { _all.push_back(&node); }
    bool has(const osg::Node& node) const
    {
        return std::find(_all.begin(), _all.end(), &node) != _all.end();
    }

private:
    std::vector<const osg::Node*> _all;
};

/// Sorts the nodes below a node by the reason why they aren't played.
class Reasons
{
public:
    Reasons(osg::Node& root, bool isTold) : _isTold(isTold)
    {
        if (osg::Drawable* drawable = root.asDrawable())
            addDrawable(*drawable, nullptr);
        else
            lookBelow(root, nullptr);
    }

    WhyUnfelt summary() const
    {
        std::vector<std::string> all;
        if (_hidden.count > 0) all.push_back("is hidden (" + _hidden.text() + ")");
        if (_missing.count > 0) all.push_back("is not loaded (" + _missing.text() + ")");
        if (_own.count > 0) all.push_back("has its own haptic tags (" + _own.text() + ")");
        if (_cameras.count > 0)
            all.push_back("hangs on a camera, not in the world (" + _cameras.text() + ")");
        if (all.empty() && _isTold) return {};
        if (all.empty() && _shapes == 0) return {"has no drawables below it", false};
        if (all.empty()) return {"has no triangles", false};
        return {"is not played: each node below it " + fmt::format("{}", fmt::join(all, ", or ")),
                _hidden.count > 0};
    }

private:
    /// \a hider: the object that hides \a node; null: it is shown.
    void look(osg::Node& node, const osg::Object* hider)
    {
        if (isOwnObject(node)) return _own.add(node);
        if (node.asCamera() || dynamic_cast<osg::Projection*>(&node)) return _cameras.add(node);
        const osg::Transform* transform = node.asTransform();
        if (transform && transform->getReferenceFrame() != osg::Transform::RELATIVE_RF)
        {
            if (hider)
                _cameras.add(node);
            else
                _isTold = true;
            return;
        }
        if (osg::Drawable* drawable = node.asDrawable()) return addDrawable(*drawable, hider);
        lookBelow(node, hider);
    }

    void lookBelow(osg::Node& node, const osg::Object* hider)
    {
        osg::Group* group = node.asGroup();
        if (!group) return;
        const std::string missing = missingFile(node);
        if (!missing.empty()) _missing.add(node, ": \"" + missing + "\"");
        const ActiveChildren active(node);
        for (unsigned int i = 0; i < group->getNumChildren(); ++i)
        {
            osg::Node& child = *group->getChild(i);
            const osg::Object* itself = child.getNodeMask() == 0 ? &child : group;
            look(child, hider || active.has(child) ? hider : itself);
        }
    }

    void addDrawable(const osg::Drawable& drawable, const osg::Object* hider)
    {
        ++_shapes;
        // The reader names objects that it can't read.
        if (hider && (_lastHider != hider || _hidden.count == 0))
            _hidden.add(*hider);
        else if (!hider && !drawable.asGeometry())
            _isTold = true;
        if (hider) _lastHider = hider;
    }

    Some _hidden;
    const osg::Object* _lastHider = nullptr;
    Some _missing;
    Some _own;
    Some _cameras;
    int _shapes = 0;
    bool _isTold; ///< an unreadable part was logged when the mesh was read
};

} // namespace

std::string missingFile(const osg::Node& node)
{
    if (const auto* paged = dynamic_cast<const osg::PagedLOD*>(&node)) return firstMissing(*paged);
    if (const auto* proxy = dynamic_cast<const osg::ProxyNode*>(&node)) return firstMissing(*proxy);
    return {};
}

void SceneMarks::look(const std::vector<const osg::Node*>& roots)
{
    const auto isMarked = [](const osg::Node* root) { return hasMark(*root); };
    if (_state == State::SOME) return;
    if (std::any_of(roots.begin(), roots.end(), isMarked)) _state = State::SOME;
    if (_state != State::UNKNOWN) return;
    // Once it is known that there are no tags, a part unloaded later had none either.
    _missing.clear();
    for (const osg::Node* root : roots)
        if (_missing.empty()) _missing = findMissing(*root);
    if (_missing.empty()) _state = State::NONE;
}

WhyUnfelt whyUnfelt(osg::Node& root, bool isTold)
{
    return Reasons(root, isTold).summary();
}

} // namespace osgMidair
