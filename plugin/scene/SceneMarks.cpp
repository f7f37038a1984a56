#include "plugin/scene/SceneMarks.h"

#include "engine-bridge/scene/GeometryReader.h"
#include "plugin/scene/CollectHapticSurfacesVisitor.h"

#include <osgMidair/HapticPoints>
#include <osgMidair/HapticSurface>

#include <osg/Group>
#include <osg/PagedLOD>
#include <osg/ProxyNode>

#include <algorithm>

namespace osgMidair
{

namespace
{

// Files are loaded in their order, each as the child of its number.
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

// Marks request the event traversal, and OSG counts such requests up to the root, hidden or not.
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
    // Once it was known that there are none, a part that is unloaded had none either.
    _missing.clear();
    for (const osg::Node* root : roots)
        if (_missing.empty()) _missing = findMissing(*root);
    if (_missing.empty()) _state = State::NONE;
}

} // namespace osgMidair
