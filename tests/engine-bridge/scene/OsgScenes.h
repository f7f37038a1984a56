#pragma once

#include <osg/Array>
#include <osg/Geometry>
#include <osg/MatrixTransform>
#include <osg/ref_ptr>

/// One triangle with corners at the origin, (1, 0, 0) and (0, 1, 0).
inline osg::ref_ptr<osg::Geometry> triangleGeometry()
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    vertices->push_back({0.0f, 0.0f, 0.0f});
    vertices->push_back({1.0f, 0.0f, 0.0f});
    vertices->push_back({0.0f, 1.0f, 0.0f});
    geometry->setVertexArray(vertices);
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, 3));
    return geometry;
}

inline osg::ref_ptr<osg::MatrixTransform> moved(const osg::Matrixd& matrix, osg::Node* child)
{
    osg::ref_ptr<osg::MatrixTransform> transform = new osg::MatrixTransform(matrix);
    transform->addChild(child);
    return transform;
}

/// A tetrahedron with a corner at the origin and three on the axes, whose faces look outwards.
inline osg::ref_ptr<osg::Geometry> cornerGeometry()
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    vertices->push_back({0.0f, 0.0f, 0.0f});
    vertices->push_back({1.0f, 0.0f, 0.0f});
    vertices->push_back({0.0f, 1.0f, 0.0f});
    vertices->push_back({0.0f, 0.0f, 1.0f});
    geometry->setVertexArray(vertices);
    osg::ref_ptr<osg::DrawElementsUByte> faces = new osg::DrawElementsUByte(GL_TRIANGLES);
    for (const GLubyte i : {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3})
        faces->push_back(i);
    geometry->addPrimitiveSet(faces);
    return geometry;
}
