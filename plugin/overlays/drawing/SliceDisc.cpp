#include "plugin/overlays/drawing/SliceDisc.h"

#include "plugin/overlays/drawing/FieldSlice.h"

#include <osg/PolygonOffset>

namespace osgMidair
{

osg::ref_ptr<osg::Texture2D> makeSliceTexture(osg::Image* image)
{
    osg::ref_ptr<osg::Texture2D> texture = new osg::Texture2D(image);
    texture->setDataVariance(osg::Object::DYNAMIC);
    texture->setResizeNonPowerOfTwoHint(false);
    texture->setFilter(osg::Texture::MIN_FILTER, osg::Texture::LINEAR);
    texture->setFilter(osg::Texture::MAG_FILTER, osg::Texture::LINEAR);
    texture->setWrap(osg::Texture::WRAP_S, osg::Texture::CLAMP_TO_EDGE);
    texture->setWrap(osg::Texture::WRAP_T, osg::Texture::CLAMP_TO_EDGE);
    return texture;
}

void setUpSliceDisc(osg::Geometry& disc, osg::Texture2D* texture)
{
    disc.setDataVariance(osg::Object::DYNAMIC);
    disc.setUseDisplayList(false);
    disc.setUseVertexBufferObjects(true);
    disc.setVertexArray(new osg::Vec3Array(4));
    osg::ref_ptr<osg::Vec2Array> coordinates = new osg::Vec2Array;
    for (const osg::Vec2& corner :
         {osg::Vec2(0, 0), osg::Vec2(1, 0), osg::Vec2(0, 1), osg::Vec2(1, 1)})
        // The centres of the outermost texels lie on the rim.
        coordinates->push_back((corner * (kSlicePixels - 1) + osg::Vec2(0.5F, 0.5F)) /
                               kSlicePixels);
    disc.setTexCoordArray(0, coordinates, osg::Array::BIND_PER_VERTEX);
    const osg::Vec4 white(1.0F, 1.0F, 1.0F, 1.0F);
    disc.setColorArray(new osg::Vec4Array(1, &white), osg::Array::BIND_OVERALL);
    disc.addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLE_STRIP, 0, 4));
    osg::StateSet* state = disc.getOrCreateStateSet();
    state->setTextureAttributeAndModes(0, texture);
    // The slice of a flat object is in its plane; the offset keeps the object in front.
    state->setAttributeAndModes(new osg::PolygonOffset(1.0F, 1.0F));
}

} // namespace osgMidair
