// What of a glTF model is read, and where it is.
#include "tests/plugin/KitTest.h"
#include "tests/plugin/gltf/GltfModel.h"
#include "tests/plugin/gltf/GltfRead.h"

#include <osg/ComputeBoundsVisitor>
#include <osg/Geode>
#include <osg/Geometry>
#include <osg/Material>
#include <osg/Texture2D>
#include <osg/ValueObject>

#include <cmath>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

std::string tagOf(const GltfModel& model, GltfMessages& messages)
{
    const osg::ref_ptr<osg::Node> root = readGltfBytes(model.gltf(), messages);
    std::string tag = "none";
    root->asGroup()->getChild(0)->getUserValue("haptic", tag);
    return tag;
}

} // namespace

TEST(Gltf, IsTurnedUprightAndPlacedByItsNodes)
{
    GltfModel model = GltfModel::triangle();
    model.json["nodes"][0]["translation"] = {10, 20, 30};
    model.json["nodes"][0]["rotation"] = {0, 0, std::sqrt(0.5), std::sqrt(0.5)}; // x to y
    model.json["nodes"][0]["scale"] = {3, 1, 1};
    for (const std::string& file : {model.gltf(), model.glb()})
    {
        const Read read(file);
        EXPECT_EQ(read.messages.all(), std::vector<std::string>());
        const Geometries found(*read.node);
        ASSERT_EQ(found.all.size(), 1U);
        // In glTF (10 20 30), (10 23 30), (8 20 30); y up is z, and z to the viewer is -y.
        expectNear(found.vertex(0, 0), osg::Vec3(10, -30, 20));
        expectNear(found.vertex(0, 1), osg::Vec3(10, -30, 23));
        expectNear(found.vertex(0, 2), osg::Vec3(8, -30, 20));
        EXPECT_EQ(found.all[0]->getPrimitiveSet(0)->getNumIndices(), 3U);
        EXPECT_NE(found.all[0]->getNormalArray(), nullptr);
    }
}

TEST(Gltf, MatricesAndChildrenPlaceToo)
{
    GltfModel model = GltfModel::triangle();
    model.json["nodes"][0]["matrix"] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 0, 0, 1};
    model.json["nodes"].push_back({{"children", {0}}, {"translation", {0, 5, 0}}});
    model.json["scenes"][0]["nodes"] = {1};
    const Read read(model.gltf());
    const Geometries found(*read.node);
    ASSERT_EQ(found.all.size(), 1U);
    expectNear(found.vertex(0, 0), osg::Vec3(1, 0, 5));
    expectNear(found.vertex(0, 1), osg::Vec3(3, 0, 5));
}

TEST(Gltf, ExtrasAreTags)
{
    GltfModel model = GltfModel::triangle();
    GltfMessages messages;
    auto& extras = model.json["nodes"][0]["extras"];
    extras = {{"haptic", true}};
    EXPECT_EQ(tagOf(model, messages), "true");
    extras = {{"haptic", 1}, {"pressure", "800 Pa"}, {"priority", 2}, {"touchEvents", true}};
    EXPECT_EQ(tagOf(model, messages),
              "true; pressure=\"800 Pa\"; priority=\"2\"; touchEvents=\"true\"");
    extras = {{"contactForce", 0.25}, {"haptic", "sampling=edges"}};
    EXPECT_EQ(tagOf(model, messages), "sampling=edges; contactForce=\"0.25\"");
    extras = {{"haptic", false}};
    EXPECT_EQ(tagOf(model, messages), "false");
    extras = {{"presure", "800 Pa\"; enabled=true"}, {"haptic", true}};
    EXPECT_EQ(tagOf(model, messages), "true; presure=\"800 Pa'; enabled=true\"");
    extras = {{"haptic", true}, {"pressure", {1, 2}}};
    EXPECT_EQ(tagOf(model, messages), "true; pressure=\"neither a text nor a number\"");
    EXPECT_EQ(messages.all(), std::vector<std::string>());
}

TEST(Gltf, ExtrasThatMarkNothingAreTold)
{
    GltfModel model = GltfModel::triangle();
    GltfMessages messages;
    auto& extras = model.json["nodes"][0]["extras"];
    extras = {{"haptik", true}, {"pressure", "800 Pa"}, {"cycles", 3}};
    EXPECT_EQ(tagOf(model, messages), "none");
    extras = {{"haptic", true}, {"cycles_visibility", 3}};
    EXPECT_EQ(tagOf(model, messages), "true");
    ASSERT_EQ(messages.all().size(), 3U);
    EXPECT_EQ(messages.all()[0], "node \"here\": unknown extra \"haptik\" (did you mean haptic?)");
    EXPECT_EQ(messages.all()[1].find("node \"here\": has the extra \"pressure\""), 0U);
    EXPECT_EQ(messages.all()[2].find("node \"here\": the extra \"cycles_visibility\""), 0U);
    extras = {{"obstacle", true}};
    bool isObstacle = false;
    const osg::ref_ptr<osg::Node> root = readGltfBytes(model.gltf(), messages);
    EXPECT_TRUE(root->asGroup()->getChild(0)->getUserValue("obstacle", isObstacle));
    EXPECT_TRUE(isObstacle);
}

TEST(Gltf, ColoursAndTexturesAreThere)
{
    findPlugins();
    GltfModel model = GltfModel::triangle();
    const std::string png = fourPixels();
    model.json["images"] = {
        {{"bufferView", model.view(png.data(), png.size())}, {"mimeType", "image/png"}},
        {{"uri", "data:image/png;base64," + GltfModel::base64(png)}}};
    model.json["textures"] = {{{"source", 0}}, {{"source", 1}}};
    for (const int texture : {0, 1})
    {
        model.json["materials"] = {{{"pbrMetallicRoughness",
                                     {{"baseColorFactor", {0.5, 0.25, 1.0, 1.0}},
                                      {"baseColorTexture", {{"index", texture}}}}}}};
        model.primitive()["material"] = 0;
        model.primitive()["attributes"]["TEXCOORD_0"] = model.floats({0, 0, 1, 0, 0, 1}, "VEC2");
        const Read read(model.gltf());
        EXPECT_EQ(read.messages.all(), std::vector<std::string>());
        const Geometries found(*read.node);
        const osg::StateSet* state = found.all.at(0)->getStateSet();
        ASSERT_TRUE(state);
        const auto* drawn = dynamic_cast<const osg::Texture2D*>(
            state->getTextureAttribute(0, osg::StateAttribute::TEXTURE));
        ASSERT_TRUE(drawn);
        // The first vertex is at the top left, which is red; images begin at the bottom in OSG.
        const auto* at = dynamic_cast<const osg::Vec2Array*>(found.all[0]->getTexCoordArray(0));
        EXPECT_EQ((*at)[0], osg::Vec2(0, 1));
        EXPECT_EQ(drawn->getImage()->getColor(0U, 1U), osg::Vec4(1, 0, 0, 1));
        const auto* overall = dynamic_cast<const osg::Vec4Array*>(found.all[0]->getColorArray());
        EXPECT_EQ((*overall)[0], osg::Vec4(0.5F, 0.25F, 1.0F, 1.0F));
    }
    const int colors = model.bytes({255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 51}, "VEC4");
    model.json["accessors"][static_cast<std::size_t>(colors)]["normalized"] = true;
    model.primitive()["attributes"]["COLOR_0"] = colors;
    const Read read(model.gltf());
    const Geometries found(*read.node);
    const auto* each = dynamic_cast<const osg::Vec4Array*>(found.all.at(0)->getColorArray());
    EXPECT_EQ(each->getBinding(), osg::Array::BIND_PER_VERTEX);
    EXPECT_EQ((*each)[2], osg::Vec4(0, 0, 1, 0.2F));
}

TEST(Gltf, AnImageThatSaysItIsHugeIsLeftOutUnread)
{
    findPlugins();
    GltfModel model = GltfModel::triangle();
    std::string png = fourPixels();
    png[17] = 1; // a width of 65,538
    model.json["images"] = {{{"bufferView", model.view(png.data(), png.size())}}};
    model.json["textures"] = {{{"source", 0}}};
    model.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    model.primitive()["material"] = 0;
    const Read read(model.gltf());
    ASSERT_EQ(read.messages.all().size(), 1U);
    EXPECT_EQ(read.messages.all()[0].find("image 0 \"\" is left out: 65538 x 2 pixels"), 0U);
    EXPECT_EQ(Geometries(*read.node).all.size(), 1U);
}

TEST(Gltf, SparseAndInterleavedNumbersAreRead)
{
    GltfModel model = GltfModel::triangle();
    const std::uint8_t index = 2;
    const std::array<float, 3> value = {0, 4, 0};
    model.json["accessors"][0]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", model.view(&index, 1)}, {"componentType", 5121}}},
        {"values", {{"bufferView", model.view(value.data(), sizeof value)}}}};
    expectNear(Geometries(*Read(model.gltf()).node).vertex(0, 2), osg::Vec3(0, 0, 4));
    // Without a buffer view the others are 0.
    model.json["accessors"][0].erase("bufferView");
    const Read zeros(model.gltf());
    expectNear(Geometries(*zeros.node).vertex(0, 1), osg::Vec3(0, 0, 0));
    expectNear(Geometries(*zeros.node).vertex(0, 2), osg::Vec3(0, 0, 4));

    GltfModel strided = GltfModel::triangle();
    const std::array<float, 15> mixed = {0, 0, 0, 9, 9, 1, 0, 0, 9, 9, 0, 2, 0, 9, 9};
    const int view = strided.view(mixed.data(), sizeof mixed);
    strided.json["bufferViews"][static_cast<std::size_t>(view)]["byteStride"] = 20;
    strided.json["accessors"][0]["bufferView"] = view;
    expectNear(Geometries(*Read(strided.gltf()).node).vertex(0, 2), osg::Vec3(0, 0, 2));
}

TEST(Gltf, WhatIsWrongIsToldByNumber)
{
    const auto changed = [](const std::function<void(GltfModel::Json&)>& change)
    {
        GltfModel model = GltfModel::triangle();
        change(model.json);
        return model;
    };
    const auto left = [&](const std::function<void(GltfModel::Json&)>& change)
    {
        const Read read(changed(change).gltf());
        return read.messages.all().empty() ? "" : read.messages.all()[0];
    };
    const std::string part = "primitive 0 of mesh 0 \"triangle\" is left out: ";
    EXPECT_EQ(left([](auto& j) { j["accessors"][0]["count"] = 4; }),
              part + "accessor 0: it goes beyond its buffer view");
    const std::string many = left([](auto& j) { j["accessors"][0]["count"] = 4000000000U; });
    EXPECT_EQ(many.find(part + "accessor 0: "), 0U) << many;
    EXPECT_NE(many.find(" 67108864 numbers"), std::string::npos) << many;
    EXPECT_EQ(left([](auto& j) { j["accessors"][0]["type"] = "VEC2"; }),
              part + "accessor 0: it has 2 components, should have 3");
    EXPECT_EQ(left([](auto& j) { j["bufferViews"][0]["byteLength"] = 999; }),
              part + "buffer view 0 goes beyond its buffer");
    EXPECT_EQ(left([](auto& j) { j["bufferViews"][0]["buffer"] = 7; }),
              part + "buffer view 0 has no buffer");
    EXPECT_EQ(left([](auto& j) { j["accessors"][0]["bufferView"] = 70; }),
              part + "there is no buffer view 70");
    const auto broken = [&](const std::function<void(GltfModel::Json&)>& change)
    { return errorOf(changed(change).gltf()); };
    EXPECT_EQ(broken([](auto& j) { j["meshes"][0]["primitives"][0]["indices"] = 99; }),
              "primitive indices accessor out of bounds");
    EXPECT_EQ(broken([](auto& j) { j["nodes"][0]["children"] = {0}; }),
              "node 0 is more than 200 deep, or below itself");
    EXPECT_EQ(
        broken([](auto& j) { j["nodes"][0]["children"] = {5}; }).find("node 0 has the child 5"),
        0U);
    EXPECT_EQ(broken(
                  [](auto& j) {
                      j["nodes"][0]["scale"] = {1e300, 1, 1};
                  }),
              "the scale of node 0 should be 3 numbers, within 1e9");
    EXPECT_EQ(broken([](auto& j) { j["nodes"][0]["mesh"] = 3; }), "there is no mesh 3");
    EXPECT_EQ(broken([](auto& j) { j["scene"] = 3; }), "there is no scene 3");
    EXPECT_EQ(broken([](auto& j) { j["asset"]["version"] = "1.0"; }),
              "its version is \"1.0\", should be 2.0");
    EXPECT_EQ(broken([](auto& j) { j["extensionsRequired"] = {"KHR_draco_mesh_compression"}; })
                  .find("it needs the extension \"KHR_draco_mesh_compression\""),
              0U);
    EXPECT_EQ(broken(
                  [](auto& j) {
                      j["nodes"][0]["extras"] = {{"priority", 5000000000}};
                  }),
              "the extra \"priority\" of nodes 0 is 5000000000, should be within 2147483647");
    EXPECT_EQ(errorOf("{").find("its JSON"), 0U);
    EXPECT_EQ(errorOf(std::string(100, '[')), "its JSON is more than 32 deep");
    EXPECT_EQ(errorOf("glTF"), "its header is cut off");
}

TEST(Gltf, NumbersThatAreNoneAreLeftOut)
{
    GltfModel model = GltfModel::triangle();
    const float nan = std::nanf("");
    std::memcpy(model.buffer.data() + 4, &nan, sizeof nan);
    const Read read(model.glb());
    EXPECT_EQ(
        read.messages.all(),
        std::vector<std::string>{"primitive 0 of mesh 0 \"triangle\" is left out: accessor 0: a "
                                 "number in it isn't finite"});
    GltfModel index = GltfModel::triangle();
    index.buffer[36] = 3; // of indices 0 1 2
    EXPECT_EQ(Read(index.glb())
                  .messages.all()
                  .at(0)
                  .find("primitive 0 of mesh 0 \"triangle\" is left out: index 3 "),
              0U);
}
