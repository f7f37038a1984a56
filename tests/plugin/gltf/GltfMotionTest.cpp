// Animations and skins of glTF models, a second after their begin.
#include "tests/plugin/KitTest.h"
#include "tests/plugin/gltf/GltfModel.h"
#include "tests/plugin/gltf/GltfRead.h"

#include <osg/Geometry>
#include <osg/ValueObject>
#include <osgAnimation/RigGeometry>

#include <cmath>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// The triangle follows a bone, at (0 0 5) above another, that turns by a quarter about z in 2 s.
GltfModel turningBone(const char* interpolation)
{
    GltfModel model = GltfModel::triangle();
    model.primitive()["attributes"]["JOINTS_0"] =
        model.bytes({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
    model.primitive()["attributes"]["WEIGHTS_0"] =
        model.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
    model.json["nodes"][0]["skin"] = 0;
    model.json["nodes"][0]["translation"] = {100, 0, 0}; // which doesn't count
    model.json["nodes"].push_back({{"name", "arm"}, {"children", {2}}, {"translation", {0, 0, 1}}});
    model.json["nodes"].push_back({{"name", "arm"}, {"translation", {0, 0, 4}}});
    model.json["scenes"][0]["nodes"] = {0, 1};
    const int inverse = model.floats({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5, 1}, "MAT4");
    model.json["skins"] = {{{"joints", {2}}, {"inverseBindMatrices", inverse}}};
    const int times = model.floats({0, 2}, "SCALAR");
    const float h = std::sqrt(0.5F);
    const bool isSpline = std::string(interpolation) == "CUBICSPLINE";
    const int turns =
        isSpline
            ? model.floats({0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, h, h, 0, 0, 0, 0},
                           "VEC4")
            : model.floats({0, 0, 0, 1, 0, 0, h, h}, "VEC4");
    model.json["animations"] = {
        {{"samplers", {{{"input", times}, {"output", turns}, {"interpolation", interpolation}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}}}}}};
    return model;
}

osg::Vec3 secondVertexAt(osg::Node& node, double time_s)
{
    osgViewer::Viewer viewer;
    viewer.setUpViewerAsEmbeddedInWindow(0, 0, 64, 64);
    viewer.setSceneData(&node);
    for (const double t : {0.0, 0.0, time_s, time_s})
    {
        viewer.advance(t);
        viewer.updateTraversal();
    }
    return Geometries(node).vertex(0, 1);
}

} // namespace

TEST(Gltf, SkinsFollowAnimatedBones)
{
    for (const char* interpolation : {"LINEAR", "CUBICSPLINE"})
    {
        const Read read(turningBone(interpolation).gltf());
        EXPECT_EQ(read.messages.all(), std::vector<std::string>());
        ASSERT_EQ(Geometries(*read.node).all.size(), 1U);
        EXPECT_TRUE(dynamic_cast<osgAnimation::RigGeometry*>(Geometries(*read.node).all[0]));
        // After 1 s by 45 degrees, (1 0 0) to (h h 0): halfway on a slerp, and on a spline with
        // flat ends, too. Its eight pieces hit the middle.
        const float h = std::sqrt(0.5F);
        expectNear(secondVertexAt(*read.node, 1.0), osg::Vec3(h, 0, h), 1e-4F);
    }
    const Read step(turningBone("STEP").gltf());
    expectNear(secondVertexAt(*step.node, 1.0), osg::Vec3(1, 0, 0), 1e-4F);
}

TEST(Gltf, SkinnedMeshesAreFeltAsTheirNodesAre)
{
    GltfModel model = turningBone("LINEAR");
    model.json["nodes"][0]["extras"] = {{"haptic", true}, {"pressure", "300 Pa"}};
    const Read read(model.gltf());
    std::string tag;
    int tagged = 0;
    const osg::Group* root = read.node->asGroup();
    for (unsigned int i = 0; i < root->getNumChildren(); ++i)
        if (root->getChild(i)->getUserValue("haptic", tag)) ++tagged;
    EXPECT_EQ(tagged, 1);
    EXPECT_EQ(tag, "true; pressure=\"300 Pa\"");
}

TEST(Gltf, AnimationsMoveNodes)
{
    GltfModel model = GltfModel::triangle();
    const int times = model.floats({0, 2}, "SCALAR");
    const int way = model.floats({0, 0, 0, 0, 6, 0}, "VEC3");
    model.json["animations"] = {
        {{"samplers", {{{"input", times}, {"output", way}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
    const Read read(model.gltf());
    expectNear(secondVertexAt(*read.node, 1.0), osg::Vec3(1, 0, 3), 1e-4F);
}
