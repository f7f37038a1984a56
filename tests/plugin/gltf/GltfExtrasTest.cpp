// Where extras of a glTF model count, and extensions that change where it is.
#include "tests/plugin/KitTest.h"
#include "tests/plugin/gltf/GltfModel.h"
#include "tests/plugin/gltf/GltfRead.h"

#include <osg/ComputeBoundsVisitor>
#include <osg/Group>
#include <osg/ValueObject>

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

using Json = GltfModel::Json;
using Messages = std::vector<std::string>;

/// The tags of a graph in its order, each once, with "obstacle" for obstacles.
class Tags : public osg::NodeVisitor
{
public:
    explicit Tags(osg::Node& root) : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) { root.accept(*this); }
    void apply(osg::Node& node) override
    {
        std::string tag;
        bool isObstacle = false;
        if (node.getUserValue("haptic", tag)) all.push_back(node.getName() + ": " + tag);
        if (node.getUserValue("reflector", tag))
            all.push_back(node.getName() + ": reflector: " + tag);
        if (node.getUserValue("obstacle", isObstacle) && isObstacle)
            all.push_back(node.getName() + ": obstacle");
        traverse(node);
    }
    Messages all;
};

Messages tagsOf(const GltfModel& model)
{
    const Read read(model.gltf());
    EXPECT_EQ(read.messages.all(), Messages());
    return Tags(*read.node).all;
}

GltfModel withMeshExtras(const Json& extras)
{
    GltfModel model = GltfModel::triangle();
    model.json["meshes"][0]["extras"] = extras;
    return model;
}

} // namespace

TEST(Gltf, ExtrasOfAMeshCountAtEachNodeThatHasIt)
{
    GltfModel model = withMeshExtras({{"haptic", true}, {"pressure", "600 Pa"}});
    EXPECT_EQ(tagsOf(model), Messages{"here: true; pressure=\"600 Pa\""});

    // A node's extras count before its mesh's, name by name.
    model.json["nodes"].push_back(
        {{"name", "there"}, {"mesh", 0}, {"extras", {{"pressure", "300 Pa"}}}});
    model.json["nodes"].push_back(
        {{"name", "nowhere"}, {"mesh", 0}, {"extras", {{"haptic", false}}}});
    model.json["scenes"][0]["nodes"] = {0, 1, 2};
    EXPECT_EQ(tagsOf(model),
              (Messages{"here: true; pressure=\"600 Pa\"",
                        "there: true; pressure=\"300 Pa\"",
                        "nowhere: false; pressure=\"600 Pa\""}));

    EXPECT_EQ(tagsOf(withMeshExtras({{"obstacle", true}})), Messages{"here: obstacle"});
    for (const Json& extras :
         {Json{{"reflector", true}, {"accuracy", 0.2}}, Json{{"reflector", {{"accuracy", 0.2}}}}})
        EXPECT_EQ(tagsOf(withMeshExtras(extras)),
                  Messages{"here: reflector: true; accuracy=\"0.2\""});
    EXPECT_EQ(tagsOf(withMeshExtras({{"haptic", {{"pressure", "600 Pa"}, {"side", "front"}}}})),
              Messages{"here: true; pressure=\"600 Pa\"; side=\"front\""});
}

TEST(Gltf, ExtrasOfAMeshAreNotThoseOfWhatIsBelowItsNode)
{
    GltfModel model = withMeshExtras({{"haptic", true}, {"pressure", "600 Pa"}});
    model.json["meshes"].push_back(model.json["meshes"][0]);
    model.json["meshes"][1].erase("extras");
    model.json["nodes"][0]["children"] = {1};
    model.json["nodes"].push_back({{"name", "below"}, {"mesh", 1}});
    EXPECT_EQ(tagsOf(model), Messages{"triangle: true; pressure=\"600 Pa\""});
    model.json["nodes"][0]["extras"] = {{"pressure", "200 Pa"}};
    EXPECT_EQ(tagsOf(model), Messages{"triangle: true; pressure=\"200 Pa\""});
    model.json["nodes"][0]["extras"] = {{"haptic", "sampling=edges"}};
    EXPECT_EQ(tagsOf(model),
              (Messages{"here: sampling=edges", "triangle: sampling=edges; pressure=\"600 Pa\""}));
}

TEST(Gltf, ExtrasOfASceneAreTagsAndSettings)
{
    GltfModel model = GltfModel::triangle();
    model.json["scenes"][0]["name"] = "room";
    model.json["scenes"][0]["extras"] = {{"haptic", true},
                                         {"pressure", "400 Pa"},
                                         {"maxPressure", "500 Pa"},
                                         {"maxPresure", "1 Pa"},
                                         {"render_engine", "x"}};
    const Read read(model.gltf());
    EXPECT_EQ(Tags(*read.node).all, Messages{": true; pressure=\"400 Pa\""});
    EXPECT_EQ(read.messages.settings(), "maxPressure=\"500 Pa\"\nmaxPresure=\"1 Pa\"\n");
    ASSERT_EQ(read.messages.all().size(), 1U);
    EXPECT_EQ(read.messages.all()[0].find("scene \"room\": the extra \"render_engine\""), 0U);
}

TEST(Gltf, ExtrasElsewhereAreToldByName)
{
    const auto told = [](const std::string& path)
    {
        GltfModel model = GltfModel::triangle();
        model.json["materials"] = {{{"name", "red"}}};
        model.json["cameras"] = {
            {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}};
        model.json["skins"] = {{{"joints", {0}}}};
        model.json["animations"] = {
            {{"name", "walk"}, {"channels", Json::array()}, {"samplers", Json::array()}}};
        model.json[Json::json_pointer(path + "/extras")] = {{"haptic", true}, {"cycles", 3}};
        const Read read(model.gltf());
        EXPECT_EQ(Tags(*read.node).all, Messages()) << path;
        EXPECT_EQ(read.messages.unfollowed().size(), 1U) << path;
        return read.messages.unfollowed().empty() ? std::string() : read.messages.unfollowed()[0];
    };
    const std::string rest = " has the extra \"haptic\"";
    EXPECT_EQ(told("/materials/0").find("materials 0" + rest), 0U);
    EXPECT_EQ(told("/meshes/0/primitives/0").find("meshes 0 primitives 0" + rest), 0U);
    EXPECT_EQ(told("/cameras/0").find("cameras 0" + rest), 0U);
    EXPECT_EQ(told("/skins/0").find("skins 0" + rest), 0U);
    EXPECT_EQ(told("/animations/0").find("animations 0" + rest), 0U);
    EXPECT_EQ(told("/asset").find("asset" + rest), 0U);
    EXPECT_EQ(told("").find("the file" + rest), 0U);
}

TEST(Gltf, APressureThatMarksNothingIsToldOnMeshesToo)
{
    const Read read(withMeshExtras({{"pressure", "600 Pa"}}).gltf());
    ASSERT_EQ(read.messages.unfollowed().size(), 1U);
    EXPECT_EQ(read.messages.unfollowed()[0].find("node \"here\": has the extra \"pressure\""), 0U);
    EXPECT_EQ(read.messages.all(), read.messages.unfollowed());
    const std::string large = errorOf(withMeshExtras({{"priority", 5000000000}}).gltf());
    EXPECT_EQ(large,
              "the extra \"priority\" of meshes 0 is 5000000000, should be within 2147483647");
}

// What gltfpack writes: positions in whole numbers, and nodes that make metres of them.
TEST(Gltf, QuantizedMeshesAreWhereTheyWere)
{
    const auto quantized = [](int kind, bool isNormalized)
    {
        GltfModel model = GltfModel::triangle();
        // (0 0 0), (1 0 0), (0 -2 0), as glTF pads them: to four bytes each
        const std::vector<std::int16_t> shorts = {0, 0, 0, 0, 100, 0, 0, 0, 0, -120, 0, 0};
        const std::vector<std::int8_t> bytes(shorts.begin(), shorts.end());
        const bool isByte = kind == 5120;
        const int view = isByte ? model.view(bytes.data(), bytes.size())
                                : model.view(shorts.data(), 2 * shorts.size());
        model.json["bufferViews"][static_cast<std::size_t>(view)]["byteStride"] = isByte ? 4 : 8;
        model.json["accessors"][0] = {{"bufferView", view},
                                      {"componentType", kind},
                                      {"count", 3},
                                      {"type", "VEC3"},
                                      {"normalized", isNormalized}};
        const double largest = isByte ? 127 : 32767;
        const double scale = 0.01 * (isNormalized ? largest : 1.0);
        model.json["nodes"][0]["scale"] = {scale, scale, scale};
        model.json["nodes"][0]["translation"] = {0, 0, 3};
        model.json["extensionsUsed"] = {"KHR_mesh_quantization"};
        model.json["extensionsRequired"] = {"KHR_mesh_quantization"};
        return model;
    };
    for (const int kind : {5120, 5122})
        for (const bool isNormalized : {false, true})
        {
            const Read read(quantized(kind, isNormalized).glb());
            EXPECT_EQ(read.messages.all(), Messages());
            const Geometries found(*read.node);
            ASSERT_EQ(found.all.size(), 1U);
            expectNear(found.vertex(0, 0), osg::Vec3(0, -3, 0));
            expectNear(found.vertex(0, 1), osg::Vec3(1, -3, 0));
            expectNear(found.vertex(0, 2), osg::Vec3(0, -3, -1.2F));
        }
}

TEST(Gltf, AllInstancesAreThere)
{
    GltfModel model = GltfModel::triangle();
    const float h = std::sqrt(0.5F);
    const int places = model.floats({0, 0, 0, 5, 0, 0}, "VEC3");
    const int turns = model.floats({0, 0, 0, 1, 0, 0, h, h}, "VEC4");
    const int sizes = model.floats({1, 1, 1, 3, 3, 3}, "VEC3");
    model.json["nodes"][0]["extras"] = {{"haptic", true}};
    Json& attributes =
        model.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    attributes = {{"TRANSLATION", places}, {"ROTATION", turns}, {"SCALE", sizes}};
    model.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
    const Read read(model.gltf());
    EXPECT_EQ(read.messages.all(), Messages());
    EXPECT_EQ(Tags(*read.node).all, Messages{"here: true"});
    const Geometries found(*read.node);
    ASSERT_EQ(found.all.size(), 2U);
    EXPECT_EQ(found.all[0], found.all[1]);
    expectNear(found.vertex(0, 1), osg::Vec3(1, 0, 0));
    expectNear(found.vertex(1, 0), osg::Vec3(5, 0, 0));
    expectNear(found.vertex(1, 1), osg::Vec3(5, 0, 3)); // x to y, three times as large

    attributes["SCALE"] = model.floats({1, 1, 1}, "VEC3");
    EXPECT_EQ(errorOf(model.gltf()).find("the instances of node 0"), 0U);
    attributes = {{"TRANSLATION", 99}};
    EXPECT_EQ(errorOf(model.gltf()), "there is no accessor 99");
    attributes = 7;
    EXPECT_EQ(errorOf(model.gltf()).find("the instances of node 0"), 0U);
}

TEST(Gltf, ExtensionsThatAreNotFollowedAreTold)
{
    GltfModel model = GltfModel::triangle();
    model.json["extensionsUsed"] = {"MPEG_haptic", "KHR_materials_ior", "KHR_mesh_quantization"};
    const Read read(model.gltf());
    ASSERT_EQ(read.messages.all().size(), 1U);
    EXPECT_NE(read.messages.all()[0].find("\"MPEG_haptic\""), std::string::npos);
    ASSERT_EQ(read.messages.ofPicture().size(), 1U);
    EXPECT_NE(read.messages.ofPicture()[0].find("\"KHR_materials_ior\""), std::string::npos);
    for (const char* needed : {"MPEG_haptic", "EXT_meshopt_compression"})
    {
        model.json["extensionsRequired"] = {needed};
        EXPECT_NE(errorOf(model.gltf()).find(std::string("it needs the extension \"") + needed),
                  std::string::npos);
    }
    // As gltfpack -c writes it: what the extension fills has no name of its own.
    model.json["buffers"].push_back({{"byteLength", 12}});
    EXPECT_NE(errorOf(model.gltf()).find("it needs the extension \"EXT_meshopt_compression\""),
              std::string::npos);
}

// Whole texture coordinates, as gltfpack writes them, need it, and paint needs texture coordinates.
TEST(Gltf, TexturesAreWhereTheirTransformSays)
{
    findPlugins();
    GltfModel model = GltfModel::triangle();
    model.json["images"] = {{{"uri", "data:image/png;base64," + GltfModel::base64(fourPixels())}}};
    model.json["textures"] = {{{"source", 0}}};
    Json& texture = model.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    texture = {{"index", 0}};
    model.primitive()["material"] = 0;
    model.primitive()["attributes"]["TEXCOORD_0"] = model.shorts({0, 0, 4095, 0, 0, 4095}, "VEC2");
    Json& way = texture["extensions"]["KHR_texture_transform"];
    const auto places = [&]
    {
        const Read read(model.gltf());
        EXPECT_EQ(read.messages.all(), Messages());
        const Geometries found(*read.node);
        return dynamic_cast<const osg::Vec2Array*>(found.all.at(0)->getTexCoordArray(0))
            ->asVector();
    };
    const auto isNear = [](const osg::Vec2& a, const osg::Vec2& b)
    { EXPECT_LT((a - b).length(), 1e-5F) << a.x() << " " << a.y(); };
    way = {{"offset", {0.25, 0.5}}, {"scale", {0.5 / 4095, 0.25 / 4095}}};
    isNear(places()[0], osg::Vec2(0.25F, 1.0F - 0.5F));
    isNear(places()[1], osg::Vec2(0.75F, 1.0F - 0.5F));
    isNear(places()[2], osg::Vec2(0.25F, 1.0F - 0.75F));
    // The example of the extension: the lower left quadrant, turned by 90 degrees.
    way = {{"offset", {0, 1}}, {"rotation", 1.57079632679}, {"scale", {0.5 / 4095, 0.5 / 4095}}};
    isNear(places()[1], osg::Vec2(0.0F, 1.0F - 0.5F));
    isNear(places()[2], osg::Vec2(0.5F, 1.0F - 1.0F));
    way = {{"offset", "left"}};
    EXPECT_EQ(Read(model.gltf()).messages.all().at(0),
              "primitive 0 of mesh 0 \"triangle\" is left out: its KHR_texture_transform has no "
              "right offset");
    way = {{"texCoord", 1}};
    EXPECT_NE(Read(model.gltf()).messages.ofPicture().at(0).find("TEXCOORD_1"), std::string::npos);
}

TEST(Gltf, ANodesWeightsOfMorphTargetsCountBeforeItsMeshs)
{
    GltfModel model = GltfModel::triangle();
    const int moved = model.floats({0, 0, 0, 1, 0, 0, 0, 0, 0}, "VEC3");
    model.primitive()["targets"] = {{{"POSITION", moved}}};
    model.json["meshes"][0]["weights"] = {1.0};
    model.json["nodes"].push_back({{"name", "there"}, {"mesh", 0}, {"weights", {3.0}}});
    model.json["scenes"][0]["nodes"] = {0, 1};
    const Read read(model.gltf());
    const Geometries found(*read.node);
    ASSERT_EQ(found.all.size(), 2U);
    expectNear(found.vertex(0, 1), osg::Vec3(2, 0, 0));
    expectNear(found.vertex(1, 1), osg::Vec3(4, 0, 0));
}

// A body of 4 units whose armature makes centimetres of metres, without inverse bind matrices.
TEST(Gltf, ASkinnedMeshIsInItsPlaceBeforeTheFirstFrame)
{
    GltfModel model = GltfModel::triangle();
    model.primitive()["attributes"]["JOINTS_0"] =
        model.bytes({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
    model.primitive()["attributes"]["WEIGHTS_0"] =
        model.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
    model.json["nodes"] = {
        {{"name", "armature"}, {"scale", {0.01, 0.01, 0.01}}, {"children", {1, 2}}},
        {{"name", "body"}, {"mesh", 0}, {"skin", 0}, {"translation", {5, 5, 5}}},
        {{"name", "hip"}, {"translation", {1, 0, 0}}}};
    model.json["skins"] = {{{"joints", {2}}}};
    const Read read(model.gltf());
    EXPECT_EQ(read.messages.all(), Messages());
    const auto look = [&]
    {
        const Geometries found(*read.node);
        expectNear(found.vertex(0, 0), osg::Vec3(0.01F, 0, 0));
        expectNear(found.vertex(0, 2), osg::Vec3(0.01F, 0, 0.02F));
        osg::ComputeBoundsVisitor bounds;
        read.node->accept(bounds);
        EXPECT_LT(bounds.getBoundingBox().radius(), 0.03F); // OSG gives it twice the room
    };
    look();
    Notices notices;
    osgViewer::Viewer viewer;
    viewer.setUpViewerAsEmbeddedInWindow(0, 0, 64, 64);
    viewer.setSceneData(read.node);
    for (const double time_s : {0.0, 0.02, 0.04})
    {
        viewer.advance(time_s);
        viewer.updateTraversal();
        look();
    }
    EXPECT_EQ(notices.text(), "");
}
