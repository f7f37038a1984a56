#include "samples/installations/shell/Looks.h"

#include <osg/BlendFunc>
#include <osg/Depth>
#include <osg/Geometry>
#include <osg/Group>
#include <osg/LineWidth>
#include <osg/Material>

namespace midair::samples
{

namespace
{

osg::ref_ptr<osg::Geometry>
plainGeometry(osg::Vec3Array* vertices, GLenum mode, const osg::Vec4& color)
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setVertexArray(vertices);
    geometry->setColorArray(new osg::Vec4Array(1, &color), osg::Array::BIND_OVERALL);
    geometry->addPrimitiveSet(new osg::DrawArrays(mode, 0, static_cast<GLsizei>(vertices->size())));
    osg::StateSet* state = geometry->getOrCreateStateSet();
    state->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    state->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
    state->setAttributeAndModes(new osg::BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA));
    state->setAttributeAndModes(new osg::Depth(osg::Depth::LEQUAL, 0.0, 1.0, false));
    state->setRenderingHint(osg::StateSet::TRANSPARENT_BIN);
    return geometry;
}

} // namespace

void paint(osg::Node& node, const osg::Vec4& color)
{
    osg::ref_ptr<osg::Material> material = new osg::Material;
    material->setDiffuse(osg::Material::FRONT_AND_BACK, color);
    material->setAmbient(osg::Material::FRONT_AND_BACK, color);
    material->setSpecular(osg::Material::FRONT_AND_BACK, {0.25F, 0.25F, 0.25F, 1.0F});
    material->setShininess(osg::Material::FRONT_AND_BACK, 32.0F);
    node.getOrCreateStateSet()->setAttributeAndModes(material);
}

osg::ref_ptr<osg::ShapeDrawable> solid(osg::Shape* shape, const osg::Vec4& color, float detail)
{
    osg::ref_ptr<osg::TessellationHints> hints = new osg::TessellationHints;
    hints->setDetailRatio(detail);
    osg::ref_ptr<osg::ShapeDrawable> drawable = new osg::ShapeDrawable(shape, hints);
    paint(*drawable, color);
    return drawable;
}

osg::ref_ptr<osg::Node> glassBox(const osg::Vec3d& centre, const osg::Vec3d& size)
{
    const osg::Vec3 low(centre - size * 0.5);
    const osg::Vec3 high(centre + size * 0.5);
    const auto corner = [&](int i)
    {
        return osg::Vec3(
            i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
    };
    osg::ref_ptr<osg::Vec3Array> edges = new osg::Vec3Array;
    for (int i = 0; i < 8; ++i)
        for (const int axis : {1, 2, 4})
            if (!(i & axis))
            {
                edges->push_back(corner(i));
                edges->push_back(corner(i | axis));
            }
    osg::ref_ptr<osg::Vec3Array> floor = new osg::Vec3Array;
    for (const int i : {0, 1, 3, 2})
        floor->push_back(corner(i));
    osg::ref_ptr<osg::Group> group = new osg::Group;
    group->addChild(plainGeometry(floor, GL_QUADS, {0.45F, 0.55F, 0.70F, 0.30F}));
    const osg::ref_ptr<osg::Geometry> lines =
        plainGeometry(edges, GL_LINES, {0.70F, 0.78F, 0.90F, 0.55F});
    lines->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(2.0F));
    group->addChild(lines);
    return group;
}

} // namespace midair::samples
