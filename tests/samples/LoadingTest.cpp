// Each program that takes a model finds the same objects in it: what tags say, or else all of it.

#include "tests/samples/installations/Run.h"

#include <map>
#include <vector>

namespace
{

const std::string kQuiet = "env OSG_MIDAIR_GRANTS= XDG_CONFIG_HOME=/nonexistent '" MIDAIR_BIN "/";

/// A box of 40 mm; \a description: of its node, which is a tag or isn't.
void writeBox(const std::string& file, const std::string& description)
{
    std::ofstream(file)
        << "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n"
           "osg::Group { UniqueID 1 Name \"box\" UserDataContainer TRUE {\n"
           "  osg::DefaultUserDataContainer { UniqueID 2 UDC_Descriptions 1 { \""
        << description
        << "\" } }\n} Children 1 {\n  osg::ShapeDrawable { UniqueID 3 Shape TRUE {\n"
           "    osg::Box { UniqueID 4 HalfLengths 0.02 0.02 0.02 } } }\n} }\n";
}

/// Says with which objects, by their paths' ends, midair-check plays \a file, and what is wrong.
std::vector<std::string> checked(const std::string& file)
{
    const Outcome run = shell(kQuiet + "midair-check' '" + file + "' --json --frames 2");
    const nlohmann::json json = nlohmann::json::parse(run.output, nullptr, false);
    std::vector<std::string> found;
    if (json.is_discarded()) return {run.output};
    for (const nlohmann::json& scene : json.at("scenes"))
        for (const nlohmann::json& object : scene.at("objects"))
        {
            const std::string path = object.at("path");
            found.push_back(path.substr(path.rfind('/') + 1));
            EXPECT_TRUE(object.at("faults").empty()) << file << ": " << object;
            EXPECT_GT(object.at("points"), 0) << file << ": " << path;
        }
    return found;
}

/// How many objects midair-demo plays of \a file.
int demonstrated(const std::string& file, const OwnFolder& out)
{
    const Outcome run = shell(kQuiet + "midair-demo' '" + file +
                              "' --headless --still --frames 10 --out '" + out.path + "'");
    EXPECT_EQ(run.code, 0) << run.output;
    std::ifstream in(out.path + "/report.json");
    const nlohmann::json json = nlohmann::json::parse(in, nullptr, false);
    if (json.is_discarded()) return -1;
    for (const nlohmann::json& message : json.at("messages"))
        EXPECT_EQ(message.get<std::string>().find("is not played"), std::string::npos) << message;
    return json.at("objects").get<int>();
}

} // namespace

TEST(Loading, AllProgramsFindTheSameObjects)
{
    const OwnFolder out("loading");
    const std::string models = out.path + "/models/";
    std::filesystem::create_directories(models);
    for (const char* name : {"panel.gltf", "star.obj", "star.mtl"})
        std::filesystem::copy_file(std::string(MIDAIR_ROOT "/samples/models/") + name,
                                   models + name);
    writeBox(models + "tagged.osgt", "haptic: pressure=4000 Pa");
    writeBox(models + "plain.osgt", "a box");
    const std::map<std::string, int> wanted = {
        {"panel.gltf", 2}, {"plain.osgt", 1}, {"star.obj", 1}, {"tagged.osgt", 1}};
    for (const auto& [name, objects] : wanted)
    {
        SCOPED_TRACE(name);
        const std::vector<std::string> viewer = checked(models + name + ".haptic");
        const std::vector<std::string> device = checked(models + name);
        EXPECT_EQ(viewer.size(), static_cast<std::size_t>(objects)) << viewer.front();
        EXPECT_EQ(device.size(), static_cast<std::size_t>(objects)) << device.front();
        const bool isTagged = name == "panel.gltf" || name == "tagged.osgt";
        if (isTagged)
        {
            EXPECT_EQ(viewer, device);
        }
        EXPECT_EQ(demonstrated(models + name, out), objects);
    }
    const Visit gallery =
        visit("gallery", "'" + models + "' --frames 600 --seconds 1 --attract 1 --size 0.12", out);
    ASSERT_EQ(gallery.outcome.code, 0) << gallery.outcome.output;
    const nlohmann::json& scene = gallery.report.at("scene");
    EXPECT_TRUE(scene.at("skipped").empty()) << scene;
    EXPECT_EQ(scene.at("objects"), nlohmann::json(wanted)) << scene;
}
