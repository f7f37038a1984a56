#include "engine-bridge/scene/SubtreeWalk.h"

#include <osg/AutoTransform>

#include <algorithm>

namespace midair::bridge
{

bool followsCamera(const osg::Transform& transform)
{
    const auto* automatic = dynamic_cast<const osg::AutoTransform*>(&transform);
    return automatic && (automatic->getAutoRotateMode() != osg::AutoTransform::NO_ROTATION ||
                         automatic->getAutoScaleToScreen());
}

osg::Matrixd cameraFreeMatrix(osg::Transform& transform, osg::NodeVisitor* visitor)
{
    osg::Matrixd matrix;
    if (!followsCamera(transform))
    {
        transform.computeLocalToWorldMatrix(matrix, visitor);
        return matrix;
    }
    // Leaves out rotation and scale set by the last cull traversal.
    const auto& automatic = static_cast<const osg::AutoTransform&>(transform);
    matrix.makeTranslate(-automatic.getPivotPoint());
    if (!automatic.getAutoScaleToScreen()) matrix.postMultScale(automatic.getScale());
    if (automatic.getAutoRotateMode() == osg::AutoTransform::NO_ROTATION)
        matrix.postMultRotate(automatic.getRotation());
    matrix.postMultTranslate(automatic.getPosition());
    return matrix;
}

void SubtreeWalk::walk(osg::Node& start, const ExtractOptions& now)
{
    options = &now;
    root = &start;
    setTraversalMask(now.traversalMask);
    matrix.makeIdentity();
    _toRoot.makeIdentity();
    identity = true;
    part = 0;
    _parts = 0;
    paint = {};
    open(0, matrix);
    if (now.paint.source == PaintOptions::TEXTURE) paintAbove(start);
    if (osg::Drawable* drawable = start.asDrawable()) visit(*drawable);
    // the root's own transform belongs to the pose
    else
        traverse(start);
}

void SubtreeWalk::paintAbove(osg::Node& start)
{
    // The nearest texture counts. Of several parents of a shared subtree the first is used.
    const osg::Node* node = &start;
    for (PaintState found; node; node = node->getNumParents() > 0 ? node->getParent(0) : nullptr)
    {
        found = {};
        found.apply(node->getStateSet());
        if (!paint.texture) paint.texture = found.texture;
        if (!paint.matrix) paint.matrix = found.matrix;
        if (!paint.isGenerated) paint.isGenerated = found.isGenerated;
        if (paint.texture && paint.matrix && paint.isGenerated) return;
    }
}

void SubtreeWalk::descend(osg::Node& node)
{
    const PaintState outer = paint;
    if (options->paint.source == PaintOptions::TEXTURE) paint.apply(node.getStateSet());
    traverse(node);
    paint = outer;
}

void SubtreeWalk::apply(osg::Node& node)
{
    if (options->skip && options->skip(node)) return;
    enter(node);
    descend(node);
}

bool SubtreeWalk::isMover(const osg::Transform& transform) const
{
    return std::binary_search(options->movers.begin(), options->movers.end(), &transform);
}

std::uint64_t SubtreeWalk::pathKey() const
{
    std::uint64_t key = 1;
    for (const osg::Node* node : _nodePath)
    {
        key = (key ^ reinterpret_cast<std::uintptr_t>(node)) * 0x9E3779B97F4A7C15ull;
        key ^= key >> 29;
    }
    return key;
}

void SubtreeWalk::apply(osg::Transform& node)
{
    if (options->skip && options->skip(node)) return;
    enter(node);
    // An absolute frame is relative to the camera, not to the world.
    if (node.getReferenceFrame() != osg::Transform::RELATIVE_RF) return;
    const osg::Matrixd outer = matrix;
    const bool outerIdentity = identity;
    const osg::Matrixd local = cameraFreeMatrix(node, this);
    if (!isMover(node))
    {
        matrix.preMult(local);
        identity = false;
        still(node, local);
        descend(node);
    }
    else
    {
        const osg::Matrixd outerToRoot = _toRoot;
        const std::size_t outerPart = part;
        _toRoot = local * matrix * _toRoot;
        matrix.makeIdentity();
        identity = true;
        part = ++_parts;
        open(pathKey(), _toRoot);
        descend(node);
        _toRoot = outerToRoot;
        part = outerPart;
    }
    matrix = outer;
    identity = outerIdentity;
}

void SubtreeWalk::apply(osg::Billboard& node)
{
    if (options->skip && options->skip(node)) return;
    enter(node);
    const PaintState outerPaint = paint;
    if (options->paint.source == PaintOptions::TEXTURE) paint.apply(node.getStateSet());
    const osg::Matrixd outer = matrix;
    for (unsigned int i = 0; i < node.getNumDrawables(); ++i)
    {
        matrix = osg::Matrixd::translate(node.getPosition(i)) * outer;
        const bool outerIdentity = identity;
        identity = false;
        if (osg::Drawable* drawable = node.getDrawable(i)) drawable->accept(*this);
        identity = outerIdentity;
    }
    matrix = outer;
    paint = outerPaint;
}

void SubtreeWalk::apply(osg::Drawable& drawable)
{
    if (options->skip && options->skip(drawable)) return;
    const PaintState outer = paint;
    if (options->paint.source == PaintOptions::TEXTURE) paint.apply(drawable.getStateSet());
    visit(drawable);
    paint = outer;
}

} // namespace midair::bridge
