#include "tests/Eventually.h"
#include "tests/samples/installations/Run.h"

#include <thread>

#include <gtest/gtest.h>

TEST(Gallery, PlaysARecordedHand)
{
    const OwnFolder out("recorded");
    const Visit run = visit("gallery",
                            "--frames 240 --size 0.12 --hands '" MIDAIR_ROOT
                            "/samples/hands/star.csv' --seconds 60",
                            out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    EXPECT_GT(run.report.at("framesWithHands"), 100); // from when the file is read
    EXPECT_GT(run.report.at("touches"), 0);
}

// As a stick that is pulled out: the model that is shown stays, and what comes back is shown again.
TEST(Gallery, GoesOnWithoutItsFolder)
{
    const OwnFolder out("gone");
    const std::string models = out.path + "/models";
    const std::string elsewhere = out.path + "/elsewhere";
    std::filesystem::create_directories(models);
    std::filesystem::copy_file(MIDAIR_ROOT "/samples/models/star.obj", models + "/star.obj");
    std::thread hand(
        [&]
        {
            letPass(3.0);
            std::filesystem::rename(models, elsewhere);
            letPass(4.0);
            std::filesystem::rename(elsewhere, models);
        });
    const Visit run = visit(
        "gallery", "'" + models + "' --minutes 0.25 --seconds 0.5 --attract 0.5 --linger 20", out);
    hand.join();
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    EXPECT_NE(run.outcome.output.find("can't read the folder"), std::string::npos)
        << run.outcome.output;
    EXPECT_GT(run.report.at("scene").at("shown").at("star.obj"), 1);
    EXPECT_GT(run.report.at("framesPlaying"), 300);
}

// The star and the panel are felt; what can't be read and what has nothing to feel are told, by
// name, once, and passed over.
TEST(Gallery, TheGalleryShowsAllModelsAndTellsTheBadOnes)
{
    const OwnFolder out("gallery");
    const std::string models = out.path + "/models";
    std::filesystem::create_directories(models);
    for (const char* name : {"star.obj", "star.mtl", "panel.gltf"})
        std::filesystem::copy_file(std::string(MIDAIR_ROOT "/samples/models/") + name,
                                   models + "/" + name);
    std::ofstream(models + "/broken.obj") << "this is no model\n";
    std::ofstream(models + "/cut.osgt") << "this is no scene\n";
    std::ofstream(models + "/corners.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1 2 3\n";
    // These end OSG's readers by a signal.
    std::ofstream(models + "/beyond.lwo", std::ios::binary)
        << std::string("FORM\0\0\0\x64LWO2PNTS\0\0\0\x24", 20) + std::string(36, '\0') + "POLS" +
               std::string("\0\0\0\x0c"
                           "FACE\0\3\0\0\0\1\xea\x60",
                           16);
    std::ofstream(models + "/beyond.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n";
    std::ofstream(models + "/beyond.ply")
        << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
           "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
           "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 900000000\n";
    std::filesystem::create_symlink("nowhere.obj", models + "/dangling.obj");
    std::ofstream(models + "/sign.osgt")
        << "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n"
           "osg::Group { UniqueID 1 Children 1 {\n osgText::Text { UniqueID 2\n"
           "  Font \"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf\"\n  CharacterSize 1 1\n"
           "  Text TRUE \"Hi\"\n  AutoRotateToScreen TRUE\n } } }\n";
    const Visit run = visit(
        "gallery", "'" + models + "' --frames 600 --seconds 1.5 --attract 1 --linger 20", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    const nlohmann::json& scene = run.report.at("scene");
    EXPECT_GE(scene.at("rounds"), 2);
    for (const char* name : {"star.obj", "panel.gltf"})
    {
        EXPECT_TRUE(scene.at("shown").contains(name)) << scene;
        EXPECT_TRUE(scene.at("felt").contains(name)) << scene;
    }
    for (const char* name :
         {"broken.obj", "cut.osgt", "sign.osgt", "beyond.obj", "beyond.ply", "beyond.lwo"})
    {
        EXPECT_TRUE(scene.at("skipped").contains(name)) << scene;
        const std::string& text = run.outcome.output;
        const std::size_t told = text.find(std::string(name) + " ");
        EXPECT_NE(text.find(name), std::string::npos) << text;
        EXPECT_EQ(text.find("midair-gallery: the model " + models + "/" + name, told + 1),
                  std::string::npos)
            << "told twice: " << text;
    }
    const std::string corners = "line 4: the face has 2 corners";
    const std::size_t first = run.outcome.output.find(corners);
    EXPECT_NE(first, std::string::npos) << run.outcome.output;
    EXPECT_EQ(run.outcome.output.find(corners, first + 1), std::string::npos) << "told each round";
    EXPECT_EQ(run.outcome.output.find("no such file"), std::string::npos) << run.outcome.output;
    for (const char* name : {"star.mtl", "dangling.obj"})
        EXPECT_NE(run.outcome.output.find(name + std::string(" is not a model")),
                  std::string::npos);
    const Visit none = visit("gallery", "'" + out.path + "'", out);
    EXPECT_EQ(none.outcome.code, 1);
    EXPECT_NE(none.outcome.output.find("no models in the folder"), std::string::npos)
        << none.outcome.output;
}
