#include "plugin/gltf/GltfScene.h"
#include "tests/fuzz/FuzzTargets.h"
#include "tests/fuzz/Require.h"

#include <osg/FrameStamp>
#include <osg/Geometry>
#include <osg/MatrixTransform>
#include <osg/TriangleIndexFunctor>
#include <osgUtil/UpdateVisitor>

#include <cmath>
#include <string>

using namespace osgMidair;

namespace
{

struct Indices
{
    unsigned int vertices = 0;
    void operator()(unsigned int a, unsigned int b, unsigned int c) const
    {
        require(a < vertices && b < vertices && c < vertices,
                "triangles refer to vertices that are there");
    }
};

class Check : public osg::NodeVisitor
{
public:
    Check() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) {}

    void apply(osg::MatrixTransform& node) override
    {
        require(node.getMatrix().valid(), "nodes have a place");
        traverse(node);
    }

    void apply(osg::Geometry& geometry) override
    {
        const auto* vertices = dynamic_cast<const osg::Vec3Array*>(geometry.getVertexArray());
        require(vertices != nullptr, "geometries have vertices");
        for (const osg::Vec3& vertex : *vertices)
            require(vertex.valid(), "vertices are finite");
        osg::TriangleIndexFunctor<Indices> indices;
        indices.vertices = static_cast<unsigned int>(vertices->size());
        geometry.accept(indices);
    }
};

} // namespace

void fuzzGltf(const std::uint8_t* data, std::size_t size)
{
    GltfMessages messages;
    try
    {
        const osg::ref_ptr<osg::Node> node =
            readGltfBytes(std::string(reinterpret_cast<const char*>(data), size), messages);
        require(node.valid(), "a model that isn't refused is there");
        Check check;
        node->accept(check);
        // Animations and skins are what OSG makes of them.
        osgUtil::UpdateVisitor update;
        const osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
        update.setFrameStamp(stamp);
        for (const double time : {0.0, 0.1, 1.0})
        {
            stamp->setSimulationTime(time);
            node->accept(update);
        }
    }
    catch (const GltfError& error)
    {
        require(*error.what() != '\0', "an error says something");
    }
    require(messages.all().size() <= GltfMessages::kMost, "messages are few");
}
