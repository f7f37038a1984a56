#pragma once

#include "engine-bridge/scene/PaintReader.h"

#include <osg/Billboard>
#include <osg/Camera>
#include <osg/Drawable>
#include <osg/Matrixd>
#include <osg/NodeVisitor>
#include <osg/Projection>
#include <osg/Transform>

#include <cstdint>
#include <functional>
#include <vector>

namespace midair::bridge
{

/// Returns true for a transform that turns or scales with the camera on screen
/// (osg::AutoTransform).
bool followsCamera(const osg::Transform& transform);

/// Returns the transform's own matrix, from its children to its parent, without camera-dependent
/// parts: a transform that follows the camera counts as unrotated and unscaled. Only for relative
/// reference frames.
osg::Matrixd cameraFreeMatrix(osg::Transform& transform, osg::NodeVisitor* visitor);

/// Options for reading a subtree: the parts that become the mesh, and their paint.
struct ExtractOptions
{
    PaintOptions paint;
    unsigned int traversalMask = ~0u; ///< nodes whose mask has none of these bits are left out
    std::function<bool(const osg::Node&)> skip; ///< subtrees to leave out; empty: none
    PaintImages* images = nullptr; ///< the cache of pictures; null: none, read each time
    /// Transforms that move separately, sorted by address: the subtree below each is a separate
    /// part, in its own coordinates.
    std::vector<const osg::Transform*> movers;
};

/// Visits each drawable of the active subtree, with its part and its matrix to that part's frame.
///
/// Part 0 is in the frame of the root's children; each mover on a path opens another part.
class SubtreeWalk : public osg::NodeVisitor
{
public:
    SubtreeWalk() : osg::NodeVisitor(NODE_VISITOR, TRAVERSE_ACTIVE_CHILDREN) {}

    /// Walks \a root's subtree; \a now must outlive the walk.
    void walk(osg::Node& root, const ExtractOptions& now);

    void apply(osg::Node& node) override;
    void apply(osg::Transform& node) override;
    void apply(osg::Billboard& node) override;
    void apply(osg::Drawable& drawable) override;
    void apply(osg::Camera&) override {}
    void apply(osg::Projection&) override {}

protected:
    /// Called for each node except the root and drawables, before its children.
    virtual void enter(osg::Node&) {}
    /// Called for a transform that is not a mover, with its matrix.
    virtual void still(osg::Transform&, const osg::Matrixd& /*local*/) {}
    /// Called for a new part: \a key identifies the path to its mover, 0: part 0; \a toRoot maps
    /// its coordinates to those of the root's children.
    virtual void open(std::uint64_t /*key*/, const osg::Matrixd& /*toRoot*/) {}
    /// Called for each drawable.
    virtual void visit(osg::Drawable& drawable) = 0;

    // NOLINTBEGIN(readability-identifier-naming): where the walk is, read by all that derive from
    // it
    const ExtractOptions* options = nullptr;
    osg::Node* root = nullptr;
    osg::Matrixd matrix; ///< to the part's frame
    bool identity = true;
    std::size_t part = 0;
    PaintState paint;
    // NOLINTEND(readability-identifier-naming)

private:
    void descend(osg::Node& node);
    bool isMover(const osg::Transform& transform) const;
    std::uint64_t pathKey() const;
    void paintAbove(osg::Node& root);

    osg::Matrixd _toRoot; ///< current part -> the root's children
    std::size_t _parts = 0;
};

} // namespace midair::bridge
