#pragma once

#include "engine-bridge/scene/GeometryReader.h"

#include <osg/Node>

#include <string>
#include <vector>

namespace osgMidair
{

/// Knows whether anything in whole graphs is marked as haptic: shown or hidden, near or far.
///
/// Hiding what is marked must not make felt what isn't, so marks that were seen once count for
/// good, those of parts that have been unloaded since too. While a part is not loaded that may have
/// the first one, nothing is known.
class SceneMarks
{
public:
    enum class State
    {
        UNKNOWN, ///< there are none in what is loaded, and something isn't
        NONE,
        SOME
    };

    /// Looks at all that is below \a roots, where markTags() has been. Not for every frame.
    void look(const std::vector<const osg::Node*>& roots);
    /// Takes note of a mark that another has seen.
    void note() { _state = State::SOME; }

    State state() const { return _state; }
    /// The first part that is not loaded: "PagedLOD 'tile' (tile.osgt)"; only where UNKNOWN.
    const std::string& missing() const { return _missing; }

private:
    State _state = State::UNKNOWN;
    std::string _missing;
};

/// Returns the first file that a PagedLOD or a ProxyNode names and has not loaded; empty: none, or
/// another node.
std::string missingFile(const osg::Node& node);

/// Some nodes or drawables of one kind, of which the first is named.
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

/// Why a marked node has no mesh.
struct WhyUnfelt
{
    std::string text;      ///< goes on after the node's path; empty: it was said already
    bool isHidden = false; ///< something below it is hidden, and is felt once it is shown
};

/// Looks at all below \a root, hidden or not, for what would be its mesh, and says why there is
/// none. For a node without a mesh, not for every frame. \a isTold: what of it can't be felt was
/// said when its mesh was read.
WhyUnfelt whyUnfelt(osg::Node& root, bool isTold);

} // namespace osgMidair
