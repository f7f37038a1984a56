#pragma once

#include "plugin/gltf/GltfScene.h"

#include <osg/Geometry>
#include <osg/NodeVisitor>
#include <osg/Transform>

#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

/// The geometries of a graph and where they are.
class Geometries : public osg::NodeVisitor
{
public:
    explicit Geometries(osg::Node& root) : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN)
    {
        root.accept(*this);
    }
    void apply(osg::Geometry& geometry) override
    {
        all.push_back(&geometry);
        places.push_back(osg::computeLocalToWorld(getNodePath()));
    }
    /// Vertex \a i of geometry \a k in the world.
    osg::Vec3 vertex(std::size_t k, unsigned int i) const
    {
        return (*dynamic_cast<const osg::Vec3Array*>(all[k]->getVertexArray()))[i] * places[k];
    }

    std::vector<osg::Geometry*> all;
    std::vector<osg::Matrixd> places;
};

struct Read
{
    explicit Read(const std::string& bytes) : node(osgMidair::readGltfBytes(bytes, messages)) {}
    osgMidair::GltfMessages messages;
    osg::ref_ptr<osg::Node> node;
};

inline std::string errorOf(const std::string& bytes)
{
    try
    {
        const Read read(bytes);
    }
    catch (const std::runtime_error& error)
    {
        return error.what();
    }
    return "nothing";
}

inline void expectNear(const osg::Vec3& a, const osg::Vec3& b, float within = 1e-5F)
{
    EXPECT_LT((a - b).length(), within) << a.x() << " " << a.y() << " " << a.z();
}
