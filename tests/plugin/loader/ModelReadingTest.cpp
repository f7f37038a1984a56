// Models as people have them: broken, or in words that OSG's readers get wrong.
#include "plugin/loader/ModelFile.h"
#include "tests/CommaLocale.h"
#include "tests/plugin/KitTest.h"
#include "tests/plugin/loader/PlyText.h"
#include "tests/plugin/loader/StockPrograms.h"

#include <osgMidair/FileFormats>

#include <osg/Geometry>
#include <osg/Material>
#include <osg/ProxyNode>
#include <osg/Texture2D>
#include <osg/TriangleFunctor>
#include <osgAnimation/RigGeometry>
#include <osgDB/ReadFile>
#include <osgDB/WriteFile>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

using namespace osgMidair;

namespace
{

const std::string kSquare = "v -0.02 -0.02 0\nv 0.02 -0.02 0\nv 0.02 0.02 0\nv -0.02 0.02 0\n";

std::string longFace()
{
    std::ostringstream text;
    std::string face = "f";
    for (int i = 0; i < 1500; ++i)
    {
        text << "v " << 0.03 * std::cos(i * 2.0 * osg::PI / 1500) << " "
             << 0.03 * std::sin(i * 2.0 * osg::PI / 1500) << " 0\n";
        face += " " + std::to_string(i + 1);
    }
    return text.str() + face + "\n";
}

/// Corners of triangles, in the frame of the node that is looked at.
struct Corners
{
    std::vector<std::vector<osg::Vec3>> all;
    std::vector<osg::Geometry*> geometries;
    std::vector<osg::StateSet*> states;
};

struct CornerVisitor : osg::NodeVisitor
{
    struct Take
    {
        void operator()(const osg::Vec3& a, const osg::Vec3& b, const osg::Vec3& c)
        {
            // The smallest first, as a reader may begin with any of the three.
            std::vector<osg::Vec3> three{a, b, c};
            std::rotate(three.begin(), std::min_element(three.begin(), three.end()), three.end());
            triangles.push_back(three);
        }
        std::vector<std::vector<osg::Vec3>> triangles;
    };

    CornerVisitor() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) {}
    void apply(osg::Geometry& geometry) override
    {
        osg::TriangleFunctor<Take> functor;
        geometry.accept(functor);
        corners.all.insert(corners.all.end(), functor.triangles.begin(), functor.triangles.end());
        corners.geometries.push_back(&geometry);
        for (osg::Node* node : getNodePath())
            if (osg::StateSet* state = node->getStateSet()) corners.states.push_back(state);
    }
    Corners corners;
};

Corners cornersOf(osg::Node& node)
{
    CornerVisitor visitor;
    node.accept(visitor);
    std::sort(visitor.corners.all.begin(), visitor.corners.all.end());
    return std::move(visitor.corners);
}

struct ModelReading : testing::Test
{
    ModelReading() { findPlugins(); }

    /// Reads NAME.haptic of a file with \a text.
    osg::ref_ptr<osg::Node>
    read(const std::string& name, const std::string& text, const std::string& options = "")
    {
        const osg::ref_ptr<osgDB::Options> given = new osgDB::Options("noRotation " + options);
        return osgDB::readRefNodeFile(folder.write(name, text) + ".haptic", given);
    }

    const TemporaryFolder folder;
};

osg::Vec3d extentOf(osg::Node& node)
{
    const osg::BoundingBoxd box = boundsOf(node);
    return box._max - box._min;
}

} // namespace

TEST_F(ModelReading, ObjFilesHaveTheShapeThatTheyAreMeantToHave)
{
    const struct
    {
        const char* name;
        std::string text;
        double width_m;
        const char* said;
    } models[] = {
        {"corners.obj", kSquare + "f 1 2\nf 1 2 3 4\n", 0.04, "line 5: the face has 2 corners"},
        {"mark.obj", "\xef\xbb\xbf" + kSquare + "usemtl a\nf 1 2 3 4\n", 0.04, ""},
        {"long.obj", longFace(), 0.06, ""},
        {"mac.obj",
         "v -0.02 0 0\rv 0.02 0 0\rv 0.02 0.04 0\rv -0.02 0.04 0\rf 1 2 3 4\r",
         0.04,
         ""},
    };
    for (const auto& model : models)
    {
        SCOPED_TRACE(model.name);
        Notices said;
        const osg::ref_ptr<osg::Node> node = read(model.name, model.text);
        ASSERT_NE(node, nullptr) << said.text();
        EXPECT_NEAR(extentOf(*node).x(), model.width_m, 1e-6); // floats
        EXPECT_NEAR(extentOf(*node).y(), model.width_m, 1e-5); // 1,500 corners
        EXPECT_NE(said.text().find(model.said), std::string::npos) << said.text();
        EXPECT_EQ(said.text().find("osgMidair: ") == std::string::npos, *model.said == '\0')
            << said.text();
    }
}

TEST_F(ModelReading, ObjFilesThatCantBeMeantAreRefusedWithTheirLine)
{
    const struct
    {
        const char* name;
        std::string text;
        const char* said;
    } models[] = {
        {"beyond.obj", kSquare + "f 1 2 9\n", "line 5: the face refers to vertex 9"},
        {"zero.obj", kSquare + "f 0 1 2\n", "line 5: face corner \"0\": indices count from 1"},
        {"comma.obj", "v 0,5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 1: \"0,5\" is not a number"},
        {"nothing.obj", "this is no model\n", "the file has no vertices"},
    };
    for (const auto& model : models)
    {
        SCOPED_TRACE(model.name);
        Notices said;
        EXPECT_EQ(read(model.name, model.text), nullptr);
        EXPECT_NE(said.text().find(model.said), std::string::npos) << said.text();
        EXPECT_NE(readModel((folder.path / model.name).string()).message().find(model.said),
                  std::string::npos);
    }
}

TEST_F(ModelReading, MapCoordinatesKeepTheirDigits)
{
    const osg::ref_ptr<osg::Node> node =
        read("map.obj",
             "v 500000.025 4649776.025 100\nv 500000.075 4649776.025 100\n"
             "v 500000.075 4649776.075 100\nv 500000.025 4649776.075 100\nf 1 2 3 4\n",
             "size=0.05");
    ASSERT_NE(node, nullptr);
    EXPECT_NEAR(extentOf(*node).x(), 0.05, 1e-6);
    EXPECT_NEAR(extentOf(*node).y(), 0.05, 1e-6);
    EXPECT_NEAR(boundsOf(*node).center().length(), 0.0, 1e-6);
    // In place, too: the reader turns y up unless it is told not to.
    const osg::ref_ptr<osg::Node> turned =
        osgDB::readRefNodeFile((folder.path / "map.obj.haptic").string());
    ASSERT_NE(turned, nullptr);
    const osg::Vec3d wanted(500000.05, -100.0, 4649776.05);
    EXPECT_NEAR((boundsOf(*turned).center() - wanted).length(), 0.0, 1e-6);
    // A format of floats can only say so.
    const std::string text = ply("3 0 2 3");
    std::string far;
    for (std::size_t i = 0; i < text.size(); ++i)
    {
        const bool isMinus = text.compare(i, 5, "-0.02") == 0;
        const bool isPlus = !isMinus && text.compare(i, 4, "0.02") == 0;
        far += isMinus ? "4649775.98" : isPlus ? "4649776.02" : text.substr(i, 1);
        i += isMinus ? 4 : isPlus ? 3 : 0;
    }
    Notices said;
    EXPECT_NE(read("map.ply", far), nullptr);
    EXPECT_NE(said.text().find("lose digits"), std::string::npos) << said.text();
}

// What is drawn of a good file is what OSG's own reader makes of it.
TEST_F(ModelReading, ObjFilesKeepTheirLooks)
{
    osg::ref_ptr<osg::Image> image = new osg::Image;
    image->allocateImage(2, 2, 1, GL_RGB, GL_UNSIGNED_BYTE);
    std::fill_n(image->data(), image->getTotalSizeInBytes(), 200);
    ASSERT_TRUE(osgDB::writeImageFile(*image, (folder.path / "paint.bmp").string()));
    folder.write("looks.mtl",
                 "newmtl red#1\nKd 0.8 0.1 0.2\nmap_Kd paint.bmp\nnewmtl blue\nKd 0.1 0.2 0.9\n");
    const std::string text =
        "mtllib looks.mtl\n" + kSquare +
        "v 0 0 0.03\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0.6 0.8\no base\nusemtl red#1\n"
        "f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/1/1\no top\nusemtl blue\ns 1\nf 1 2 5\nf 2 3 5\n";
    const std::string file = folder.write("looks.obj", text);
    const osg::ref_ptr<osg::Node> plain = osgDB::readRefNodeFile(file);
    osgDB::ReaderWriter::ReadResult result = readModel(file);
    ASSERT_NE(plain, nullptr);
    ASSERT_TRUE(result.validNode()) << result.message();
    const Corners before = cornersOf(*plain);
    const Corners after = cornersOf(*result.getNode());
    EXPECT_EQ(after.all.size(), 4U);
    EXPECT_EQ(after.all, before.all);
    ASSERT_EQ(after.geometries.size(), before.geometries.size());
    for (std::size_t i = 0; i < before.geometries.size(); ++i)
    {
        const auto* wanted = dynamic_cast<osg::Vec3Array*>(before.geometries[i]->getNormalArray());
        const auto* normals = dynamic_cast<osg::Vec3Array*>(after.geometries[i]->getNormalArray());
        ASSERT_TRUE(wanted && normals);
        EXPECT_EQ(normals->asVector(), wanted->asVector());
    }
    ASSERT_EQ(after.states.size(), before.states.size());
    int materials = 0;
    int textures = 0;
    for (std::size_t i = 0; i < before.states.size(); ++i)
    {
        const auto of = [](osg::StateSet& state)
        { return dynamic_cast<osg::Material*>(state.getAttribute(osg::StateAttribute::MATERIAL)); };
        const osg::Material* wanted = of(*before.states[i]);
        const osg::Material* material = of(*after.states[i]);
        ASSERT_EQ(material == nullptr, wanted == nullptr);
        if (wanted)
        {
            EXPECT_EQ(material->getDiffuse(osg::Material::FRONT),
                      wanted->getDiffuse(osg::Material::FRONT));
            ++materials;
        }
        const auto* texture = dynamic_cast<osg::Texture2D*>(
            after.states[i]->getTextureAttribute(0, osg::StateAttribute::TEXTURE));
        if (!texture || !texture->getImage()) continue;
        EXPECT_EQ(texture->getImage()->getFileName(), (folder.path / "paint.bmp").string());
        ++textures;
    }
    EXPECT_EQ(materials, 2);
    EXPECT_EQ(textures, 1);
}

TEST_F(ModelReading, APaintIsThatOfTheObjectThatHasIt)
{
    std::string text = "o plain\n" + kSquare + "f 1 2 3 4\no painted\n";
    for (const char* place : {"1 0 0", "2 0 0", "2 1 0", "1 1 0"})
        text += "v " + std::string(place) + " 0.25 0.5 0.75\n";
    const osg::ref_ptr<osg::Node> node = read("painted.obj", text + "f 5 6 7 8\n");
    ASSERT_NE(node, nullptr);
    int painted = 0;
    for (osg::Geometry* geometry : cornersOf(*node).geometries)
    {
        const auto* places = dynamic_cast<osg::Vec3Array*>(geometry->getVertexArray());
        const auto* colours = dynamic_cast<osg::Vec4Array*>(geometry->getColorArray());
        ASSERT_TRUE(places && colours && colours->size() == places->size());
        for (std::size_t i = 0; i < places->size(); ++i)
        {
            const bool isPainted = (*places)[i].x() > 0.5F;
            EXPECT_EQ((*colours)[i],
                      isPainted ? osg::Vec4(0.25F, 0.5F, 0.75F, 1.0F)
                                : osg::Vec4(1.0F, 1.0F, 1.0F, 1.0F));
            painted += isPainted ? 1 : 0;
        }
    }
    EXPECT_GE(painted, 4);
}

// This one ends OSG's reader by a signal: of another process.
TEST_F(ModelReading, WhatEndsOsgsReaderIsRefusedByName)
{
    std::string lwo("FORM\0\0\0\x64LWO2PNTS\0\0\0\x24", 20);
    lwo += std::string(36, '\0') + "POLS" + std::string("\0\0\0\x0c", 4) + "FACE" +
           std::string("\0\3\0\0\0\1\xea\x60", 8);
    Notices said;
    EXPECT_EQ(read("broken.lwo", lwo), nullptr);
    EXPECT_NE(
        said.text().find("broken.lwo: the process that tried to read it was killed by signal "),
        std::string::npos)
        << said.text();
}

// What a driver would read beyond its memory, and a reader of the mesh.
TEST_F(ModelReading, FacesWithoutTheirVerticesAreLeftOut)
{
    const osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    const osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    for (const osg::Vec3& vertex :
         {osg::Vec3(), osg::Vec3(0.1F, 0, 0), osg::Vec3(0.1F, 0.1F, 0), osg::Vec3(0, 0.1F, 0)})
        vertices->push_back(vertex);
    geometry->setVertexArray(vertices);
    geometry->setNormalArray(new osg::Vec3Array(3), osg::Array::BIND_PER_VERTEX);
    const GLuint inside[] = {0, 1, 2};
    const GLuint outside[] = {0, 2, 77};
    geometry->addPrimitiveSet(new osg::DrawElementsUInt(GL_TRIANGLES, 3, outside));
    geometry->addPrimitiveSet(new osg::DrawElementsUInt(GL_TRIANGLES, 3, inside));
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 2, 3));
    const std::string file = (folder.path / "far.osgt").string();
    ASSERT_TRUE(osgDB::writeNodeFile(*geometry, file));
    Notices said;
    osgDB::ReaderWriter::ReadResult result = readModel(file);
    ASSERT_TRUE(result.validNode()) << said.text();
    EXPECT_NE(said.text().find("far.osgt: 2 of its sets of faces"), std::string::npos)
        << said.text();
    const Corners left = cornersOf(*result.getNode());
    ASSERT_EQ(left.geometries.size(), 1U);
    EXPECT_EQ(left.geometries[0]->getNumPrimitiveSets(), 1U);
    EXPECT_EQ(left.geometries[0]->getNormalArray(), nullptr) << "there are too few";
    EXPECT_EQ(left.all.size(), 1U);
}

TEST_F(ModelReading, APipeHoldsNothingUp)
{
    for (const char* name : {"waits.ply", "waits.obj", "waits.osgt"})
    {
        const std::string pipe = (folder.path / name).string();
        ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
        EXPECT_EQ(readModel(pipe).message(),
                  pipe + ": is a device or a pipe, should be a regular file");
    }
}

TEST_F(ModelReading, WhatAModelNamesIsReadTheSameWay)
{
    folder.write("inner.obj", kSquare + "f 1 2\nf 1 2 3 4\n");
    folder.write("wrong.obj", kSquare + "f 1 2 9\n");
    const osg::ref_ptr<osg::ProxyNode> names = new osg::ProxyNode;
    names->setFileName(0, "inner.obj");
    names->setFileName(1, "wrong.obj");
    ASSERT_TRUE(osgDB::writeNodeFile(*names, (folder.path / "outer.osgt").string()));
    Notices said;
    const osg::ref_ptr<osg::Node> node =
        osgDB::readRefNodeFile((folder.path / "outer.osgt.haptic").string());
    ASSERT_NE(node, nullptr) << said.text();
    EXPECT_EQ(cornersOf(*node).all.size(), 2U) << said.text();
    for (const char* text : {"inner.obj, line 5: the face has 2 corners",
                             "wrong.obj, line 5: the "
                             "face refers to vertex 9"})
        EXPECT_NE(said.text().find(text), std::string::npos) << said.text();
}

TEST_F(ModelReading, NumbersHaveAPointInAnyLocale)
{
    const CommaLocale german;
    if (!german.isSet()) GTEST_SKIP();
    for (const auto& [name, text] :
         {std::pair<std::string, std::string>("point.obj", kSquare + "f 1 2 3 4\n"),
          {"point.ply", ply("3 0 2 3")}})
    {
        const osg::ref_ptr<osg::Node> node = read(name, text);
        ASSERT_NE(node, nullptr) << name;
        EXPECT_NEAR(extentOf(*node).x(), 0.04, 1e-6) << name;
        EXPECT_NEAR(extentOf(*node).y(), 0.04, 1e-6) << name;
    }
}

// OSG doubles them, so that a skin stays within them however it moves.
TEST_F(ModelReading, TheBoundsOfASkinAreThoseOfItsVertices)
{
    const osg::ref_ptr<osg::Vec3Array> corners = new osg::Vec3Array;
    for (const osg::Vec3& corner : {osg::Vec3(0, 0, 0), osg::Vec3(1, 0, 0), osg::Vec3(0, 2, 0)})
        corners->push_back(corner);
    const osg::ref_ptr<osgAnimation::RigGeometry> skin = new osgAnimation::RigGeometry;
    skin->setVertexArray(corners);
    EXPECT_EQ(extentOf(*skin), osg::Vec3d(1, 2, 0));
}

// OSG takes the object that had the number first: it would become its own child.
TEST_F(ModelReading, AChildWithTheNumberOfAnObjectAroundItIsRefused)
{
    const auto scene = [](const char* group, const char* haptics, const char* child)
    {
        return std::string("#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n"
                           "osg::Group { UniqueID ") +
               group + " Children 1 {\nosgMidair::HapticScene { UniqueID " + haptics +
               " Name \"a } UniqueID 1\" Children 1 {\nosgMidair::HapticSurface { UniqueID " +
               child + " }\n} } } }\n";
    };
    EXPECT_TRUE(readModel(folder.write("good.osgt", scene("1", "2", "3"))).validNode());
    for (const auto& [text, line] : {std::pair(scene("1", "2", "2"), "line 6: UniqueID 2 "),
                                     {scene("1", "2", "1"), "line 6: UniqueID 1 "},
                                     {scene("1", "1", "3"), "line 5: UniqueID 1 "}})
    {
        osgDB::ReaderWriter::ReadResult read = readModel(folder.write("wrong.osgt", text));
        EXPECT_FALSE(read.validNode());
        EXPECT_NE(read.message().find(line), std::string::npos) << read.message();
    }
    // A viewer reads it by OSG's own reader.
    const osg::ref_ptr<osg::Node> viewed =
        osgDB::readRefNodeFile(folder.write("viewed.osgt", scene("1", "2", "2")));
    EXPECT_EQ(viewed, nullptr);
    const osg::ref_ptr<osg::Node> good = readModel((folder.path / "good.osgt").string()).getNode();
    const std::string saved = (folder.path / "good.osgx").string();
    ASSERT_TRUE(osgDB::writeNodeFile(*good, saved));
    std::ifstream in(saved);
    std::string xml{std::istreambuf_iterator<char>(in), {}};
    EXPECT_TRUE(readModel(folder.write("again.osgx", xml)).validNode());
    const std::string own = "<UniqueID attribute=\"3\"";
    ASSERT_NE(xml.find(own), std::string::npos) << xml;
    xml.replace(xml.find(own), own.size(), "<UniqueID attribute=\"2\"");
    const std::string wrong = folder.write("wrong.osgx", xml);
    osgDB::ReaderWriter::ReadResult read = readModel(wrong);
    EXPECT_FALSE(read.validNode());
    EXPECT_NE(read.message().find("UniqueID 2 "), std::string::npos);
    EXPECT_EQ(osgDB::readRefNodeFile(wrong), nullptr);
    // The same object in two places.
    EXPECT_TRUE(readModel(folder.write("twice.osgt",
                                       "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph "
                                       "3.6.5\nosg::Group { UniqueID 1 Children 2 {\n"
                                       "osg::Group { UniqueID 2 }\nosg::Group { UniqueID 2 }\n"
                                       "} }\n"))
                    .validNode());
}
