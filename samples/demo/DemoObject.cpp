#include "samples/demo/DemoObject.h"

#include "engine-bridge/scene/MeshExtractor.h"
#include "haptics/base/Units.h"
#include "plugin/overlays/drawing/DiscGeometry.h"

#include <osg/ComputeBoundsVisitor>
#include <osg/Geometry>
#include <osg/LightModel>
#include <osg/LightSource>
#include <osg/LineWidth>
#include <osg/Material>
#include <osgDB/FileNameUtils>
#include <osgDB/ReadFile>
#include <osgUtil/SmoothingVisitor>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

namespace midair::samples
{

namespace
{

/// Ratio of the smallest to the middle extent below which an object counts as flat.
constexpr double kFlat = 0.35;

/// Returns, for each vertex, the first vertex at the same place, so that triangles that share an
/// edge can be found.
std::vector<int> welded(const haptics::TriangleMesh& mesh)
{
    const double grid = 1e-6 * std::max(1e-9, mesh.extent().maxCoeff());
    std::map<std::array<long, 3>, int> firsts;
    std::vector<int> like(static_cast<std::size_t>(mesh.vertices.cols()));
    for (Eigen::Index i = 0; i < mesh.vertices.cols(); ++i)
    {
        const Eigen::Vector3d v = mesh.vertices.col(i) / grid;
        like[i] = firsts
                      .try_emplace({std::lround(v.x()), std::lround(v.y()), std::lround(v.z())},
                                   static_cast<int>(i))
                      .first->second;
    }
    return like;
}

/// Returns edges with one triangle, or with two triangles that are turned by more than 35 degrees.
/// Returns none if there are too many to look good: more than a tenth of all edges of a solid.
osg::ref_ptr<osg::Vec3Array> featureEdges(const haptics::TriangleMesh& mesh, bool flat)
{
    const std::vector<int> like = welded(mesh);
    std::map<std::pair<int, int>, std::vector<Eigen::Vector3d>>
        edges; // normals of the triangles on each
    for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t)
    {
        const Eigen::Vector3d a = mesh.vertices.col(mesh.triangles(0, t));
        const Eigen::Vector3d b = mesh.vertices.col(mesh.triangles(1, t));
        const Eigen::Vector3d c = mesh.vertices.col(mesh.triangles(2, t));
        const Eigen::Vector3d normal = (b - a).cross(c - a);
        if (normal.norm() <= 0.0) continue;
        for (int k = 0; k < 3; ++k)
        {
            const int from = like[mesh.triangles(k, t)];
            const int to = like[mesh.triangles((k + 1) % 3, t)];
            if (from != to) edges[std::minmax(from, to)].push_back(normal.normalized());
        }
    }
    const double sharp = std::cos(midair::base::toRadians(35.0));
    osg::ref_ptr<osg::Vec3Array> lines = new osg::Vec3Array;
    for (const auto& [edge, normals] : edges)
        if (normals.size() == 1 || (normals.size() == 2 && normals[0].dot(normals[1]) < sharp))
            for (const int end : {edge.first, edge.second})
            {
                const Eigen::Vector3d v = mesh.vertices.col(end);
                lines->push_back(osg::Vec3(osg::Vec3d(v.x(), v.y(), v.z())));
            }
    if (!flat && lines->size() / 2 > edges.size() / 10) lines->clear();
    return lines;
}

osg::ref_ptr<osg::Node> lineNode(osg::Vec3Array* lines)
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setVertexArray(lines);
    const osg::Vec4 color(0.96F, 0.97F, 1.0F, 0.75F);
    geometry->setColorArray(new osg::Vec4Array(1, &color), osg::Array::BIND_OVERALL);
    geometry->addPrimitiveSet(
        new osg::DrawArrays(GL_LINES, 0, static_cast<GLsizei>(lines->size())));
    osgMidair::drawTranslucent(*geometry, osgMidair::TRANSLUCENT_OBJECT_BIN);
    geometry->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(2.0F));
    return geometry;
}

/// Adds smooth normals to geometry without normals, except at creases.
class AddMissingNormals : public osgUtil::SmoothingVisitor
{
public:
    void apply(osg::Geometry& geometry) override
    {
        if (!geometry.getNormalArray()) osgUtil::SmoothingVisitor::apply(geometry);
    }
};

/// Makes the model matt and light unless the file has materials, and transparent if it is flat.
void dress(osg::Node& model, bool flat)
{
    osg::ref_ptr<osg::Material> material = new osg::Material;
    const float alpha = flat ? 0.13F : 1.0F;
    material->setDiffuse(osg::Material::FRONT_AND_BACK, {0.80F, 0.82F, 0.86F, alpha});
    material->setAmbient(osg::Material::FRONT_AND_BACK, {0.80F, 0.82F, 0.86F, alpha});
    material->setSpecular(osg::Material::FRONT_AND_BACK, {0.18F, 0.18F, 0.18F, alpha});
    material->setShininess(osg::Material::FRONT_AND_BACK, 24.0F);
    osg::StateSet* state = model.getOrCreateStateSet();
    const auto mode =
        flat ? osg::StateAttribute::ON | osg::StateAttribute::OVERRIDE : osg::StateAttribute::ON;
    state->setAttributeAndModes(material, mode);
    if (!flat) return;
    osgMidair::drawTranslucent(model, osgMidair::TRANSLUCENT_OBJECT_BIN);
    state->setRenderBinDetails(osgMidair::TRANSLUCENT_OBJECT_BIN,
                               "DepthSortedBin",
                               osg::StateSet::OVERRIDE_RENDERBIN_DETAILS);
    state->setMode(GL_LIGHTING, osg::StateAttribute::ON);
}

osg::ref_ptr<osg::Light> light(int number, const osg::Vec4& direction, float brightness)
{
    osg::ref_ptr<osg::Light> made = new osg::Light(number);
    made->setPosition(direction); // w = 0: directional light
    made->setAmbient({0.0F, 0.0F, 0.0F, 1.0F});
    made->setDiffuse(osg::Vec4(1.0F, 0.98F, 0.95F, 1.0F) * brightness);
    made->setSpecular(osg::Vec4(1.0F, 1.0F, 1.0F, 1.0F) * (0.6F * brightness));
    return made;
}

} // namespace

DemoObject loadDemoObject(const std::string& path, double size_m)
{
    DemoObject object;
    object.name = osgDB::getSimpleFileName(path);
    const osg::ref_ptr<osg::Node> read = osgDB::readRefNodeFile(path);
    if (!read)
        throw std::runtime_error("can't read the model " + path +
                                 ": no such file, or no format that OpenSceneGraph knows");
    osg::ComputeBoundsVisitor bounds;
    read->accept(bounds);
    const osg::BoundingBox box = bounds.getBoundingBox();
    if (!box.valid() || box.radius() <= 0.0F)
        throw std::runtime_error("the model " + path + " has no extent: nothing to feel");
    const osg::Vec3d extent(box._max - box._min);
    const double largest = std::max({extent.x(), extent.y(), extent.z()});
    const double scale = size_m > 0.0 ? size_m / largest : 1.0;
    object.extent_m = extent * scale;
    std::array<double, 3> sorted = {extent.x(), extent.y(), extent.z()};
    std::sort(sorted.begin(), sorted.end());
    object.flat = sorted[0] < kFlat * sorted[1];

    osg::ref_ptr<osg::MatrixTransform> placed = new osg::MatrixTransform(
        osg::Matrix::translate(-box.center()) * osg::Matrix::scale(scale, scale, scale));
    placed->addChild(read);
    placed->getOrCreateStateSet()->setMode(GL_NORMALIZE, osg::StateAttribute::ON);
    AddMissingNormals smoothing;
    smoothing.setCreaseAngle(osg::DegreesToRadians(35.0));
    read->accept(smoothing);
    dress(*placed, object.flat);
    object.model = placed;
    osg::ref_ptr<osg::Group> whole = new osg::Group;
    whole->addChild(placed);
    object.edges = lineNode(featureEdges(bridge::extractMesh(*whole).mesh(), object.flat));
    return object;
}

osg::ref_ptr<osg::Group> lit(osg::Node* scene)
{
    osg::ref_ptr<osg::Group> group = new osg::Group;
    osg::StateSet* state = group->getOrCreateStateSet();
    osg::ref_ptr<osg::LightModel> model = new osg::LightModel;
    model->setAmbientIntensity({0.16F, 0.17F, 0.20F, 1.0F});
    model->setTwoSided(true);
    state->setAttributeAndModes(model);
    state->setMode(GL_LIGHTING, osg::StateAttribute::ON);
    const osg::Vec4 directions[] = {{-0.5F, -0.7F, 0.9F, 0.0F}, {0.8F, -0.4F, -0.2F, 0.0F}};
    const float brightness[] = {0.72F, 0.25F};
    for (int i = 0; i < 2; ++i)
    {
        osg::ref_ptr<osg::LightSource> source = new osg::LightSource;
        source->setLight(light(i, directions[i], brightness[i]));
        source->setStateSetModes(*state, osg::StateAttribute::ON);
        group->addChild(source);
    }
    group->addChild(scene);
    return group;
}

} // namespace midair::samples
