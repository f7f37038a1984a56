#pragma once

#include "engine-bridge/scene/GeometryReader.h"

#include <osg/Node>

#include <string>
#include <vector>

namespace osgMidair
{

/// Tracks whether anything in whole graphs is tagged as haptic: shown or hidden, near or far.
///
/// Hiding tagged objects must not make untagged ones touchable, so a tag that was seen once counts
/// for good, even after its part was unloaded. While a part that may have the first tag is not
/// loaded, the state is unknown.
class SceneMarks
{
public:
    enum class State
    {
        UNKNOWN, ///< no tags in the loaded parts, and some part isn't loaded
        NONE,
        SOME
    };

    /// Checks everything below \a roots, where markTags() has run. Not for every frame.
    void look(const std::vector<const osg::Node*>& roots);
    /// Notes a tag found elsewhere.
    void note() { _state = State::SOME; }

    State state() const { return _state; }
    /// The first part that is not loaded: "PagedLOD 'tile' (tile.osgt)"; only if UNKNOWN.
    const std::string& missing() const { return _missing; }

private:
    State _state = State::UNKNOWN;
    std::string _missing;
};

/// Returns the first file of a PagedLOD or a ProxyNode that is not loaded; empty: none, or another
/// kind of node.
std::string missingFile(const osg::Node& node);

/// Some nodes or drawables of one kind; names the first.
struct Some
{
    int count = 0;
    std::string first;

    void add(const osg::Object& object, const std::string& more = std::string())
    {
        if (count++ == 0) first = midair::bridge::quoted(object) + more;
    }
    std::string text() const
    {
        return count > 1 ? first + " and " + std::to_string(count - 1) + " more" : first;
    }
};

/// Why a tagged node has no mesh.
struct WhyUnfelt
{
    std::string text;      ///< continues after the node's path; empty: already logged
    bool isHidden = false; ///< something below it is hidden; it is played once that is shown
};

/// Explains why \a root has no mesh, from all nodes below it, hidden or not. For a node without a
/// mesh, not for every frame. \a isTold: unplayable parts were logged when its mesh was read.
WhyUnfelt whyUnfelt(osg::Node& root, bool isTold);

} // namespace osgMidair
