// Hands and models of somebody else's: scenes that would listen to the network or start programs,
// datagrams without end, models that name files or say that they are huge.
#include "engine-bridge/hands/osc/OscReceiver.h"
#include "engine-bridge/hands/osc/OscSender.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
#include "tests/hostile/Hostile.h"
#include "tests/plugin/gltf/GltfModel.h"

#include <atomic>
#include <thread>

#include <sys/resource.h>
#include <sys/socket.h>

using namespace osgMidair;

namespace
{

/// A port that was free just now.
int freePort()
{
    const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
    const auto any = midair::bridge::SocketAddress::parse("127.0.0.1", 0);
    EXPECT_EQ(::bind(socket, any.get(), any.size()), 0);
    const int port = midair::bridge::SocketAddress::boundTo(socket).port();
    ::close(socket);
    return port;
}

double memory_MiB()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

class HostileHands : public Hostile
{
};

class HostileModel : public testing::Test
{
protected:
    void SetUp() override { findPlugins(); }

    /// What is said of the model, which may not be read.
    std::string refused(const std::string& file)
    {
        Workplace::write(_place.beside("evil.gltf"), file);
        Notices notices;
        EXPECT_EQ(osgDB::readRefNodeFile(_place.beside("evil.gltf.haptic")), nullptr);
        return notices.text();
    }

    const Workplace _place;
};

} // namespace

INSTANTIATE_TEST_SUITE_P(Formats, HostileHands, testing::Values("osgt", "osgb", "osgx"));

TEST_P(HostileHands, AFileOpensNoPortAndNoHelper)
{
    const std::string mark = _place.outside("mark");
    const std::string helper =
        Workplace::write(_place.beside("helper.sh"), "#!/bin/sh\ntouch " + mark + "\n");
    std::filesystem::permissions(helper, std::filesystem::perms::owner_all);
    for (const bool isTrusted : {false, true})
    {
        const Variable trust("OSG_MIDAIR_TRUST", isTrusted ? "scene" : "");
        std::vector<std::string> asked = {"osc:?address=0.0.0.0",
                                          "openxr:?process=helper&helper=" + helper};
        if (!isTrusted) asked.insert(asked.end(), {"osc:", "openxr:?process=helper"});
        for (const std::string& hands : asked)
        {
            const auto scene = fromFile([&](HapticScene& s) { s.setHands(hands); });
            ASSERT_TRUE(scene);
            const auto viewer = view(*scene);
            EXPECT_EQ(SceneAccess::engine(*scene).hands().active(), nullptr) << hands;
            EXPECT_TRUE(says(*scene, "asks for the hands \"" + hands)) << messages(*scene);
        }
    }
    EXPECT_FALSE(std::filesystem::exists(mark));
    // A grant of the user's is one.
    const std::string port = "osc:?port=" + std::to_string(freePort());
    Workplace::write(_place.outside("grants"), "visitor = " + port + "\n");
    const auto scene = fromFile([](HapticScene& s) { s.setHands("visitor"); });
    const auto viewer = view(*scene);
    EXPECT_NE(SceneAccess::engine(*scene).hands().active(), nullptr) << messages(*scene);
}

TEST(HostileDatagrams, AFloodLeavesTheSceneAsItIs)
{
    findPlugins();
    const int port = freePort();
    BoxScene box;
    box.scene->setHands("osc:?port=" + std::to_string(port));
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const double before_MiB = memory_MiB();
    std::atomic<bool> isOver{false};
    std::atomic<int> sent{0};
    std::thread flood(
        [&]
        {
            const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
            const auto to = midair::bridge::SocketAddress::parse("127.0.0.1", port);
            std::string bytes(1400, '\0');
            for (unsigned int k = 0; !isOver; ++k)
            {
                // Half of them are no OSC, half are of an address that changes.
                bytes.replace(0, 16, k % 2 == 0 ? "#bundle\xFF" : "/" + std::to_string(k));
                bytes.resize(1400, '\0');
                ::sendto(socket, bytes.data(), bytes.size(), 0, to.get(), to.size());
                ++sent;
            }
            ::close(socket);
        });
    int frames = 0;
    EXPECT_TRUE(viewer.framesUntil([&] { return ++frames >= 100 && sent >= 50000; }));
    isOver = true;
    flood.join();
    viewer.frames(3);
    EXPECT_EQ(box.scene->getStatistics().hands, 0);
    // One of each kind, whatever came: no OSC, another address, and that it is a flood.
    EXPECT_GE(box.scene->getStatistics().messages.size(), 1U);
    EXPECT_LE(box.scene->getStatistics().messages.size(), 3U);
    EXPECT_LT(memory_MiB() - before_MiB, 30.0);
    EXPECT_GT(box.points(), 0);
}

TEST_F(HostileModel, NamesNoFilesOutsideOfItsFolder)
{
    Workplace::write(_place.outside("secret.bin"), std::string(42, 's'));
    std::filesystem::create_symlink(_place.outside("secret.bin"), _place.beside("link.bin"));
    std::filesystem::create_directory(_place.beside("folder.bin"));
    GltfModel model = GltfModel::triangle();
    for (const std::string& uri : {std::string("../secret.bin"),
                                   std::string("..%2fsecret.bin"),
                                   std::string("link.bin"),
                                   std::string("./x/../../secret.bin"),
                                   _place.outside("secret.bin"),
                                   std::string("/etc/passwd"),
                                   std::string("/dev/zero"),
                                   std::string("file:///etc/passwd"),
                                   std::string("http://localhost/a.bin"),
                                   std::string("$(touch /tmp/x)"),
                                   std::string("~/.ssh/id_rsa"),
                                   std::string("folder.bin"),
                                   std::string()})
    {
        model.json["buffers"] = {{{"byteLength", 42}, {"uri", uri}}};
        EXPECT_NE(refused(model.json.dump()).find("can't be read: "), std::string::npos) << uri;
    }
    model.json["buffers"] = {{{"byteLength", 42}, {"uri", "../secret.bin"}}};
    EXPECT_NE(refused(model.json.dump()).find("secret.bin, outside of its folder"),
              std::string::npos);
    // Images, too.
    GltfModel image = GltfModel::triangle();
    image.json["images"] = {{{"uri", "../secret.bin"}}};
    EXPECT_NE(refused(image.gltf()).find("outside of its folder"), std::string::npos);
}

TEST_F(HostileModel, TakesNoMemoryThatItDoesNotHave)
{
    const double before_MiB = memory_MiB();
    GltfModel huge = GltfModel::triangle();
    huge.json["accessors"][0].erase("bufferView");
    huge.json["accessors"][0]["count"] = 4000000000U;
    Workplace::write(_place.beside("huge.gltf"), huge.gltf());
    Notices notices;
    osgDB::readRefNodeFile(_place.beside("huge.gltf.haptic"));
    EXPECT_NE(notices.text().find(" 67108864 numbers"), std::string::npos) << notices.text();
    // Each buffer without a name is a copy of what there is.
    GltfModel copies = GltfModel::triangle();
    for (int i = 0; i < 60; ++i)
        copies.json["buffers"].push_back({{"byteLength", 42}});
    EXPECT_NE(refused(copies.json.dump()).find("has no uri"), std::string::npos);
    GltfModel large = GltfModel::triangle();
    large.json["buffers"] = {
        {{"byteLength", 1e18}, {"uri", "data:application/octet-stream;base64,AAAA"}}};
    EXPECT_NE(refused(large.json.dump()).find("can't be read"), std::string::npos);
    EXPECT_NE(refused(std::string(1 << 20, '[')).find("more than 32 deep"), std::string::npos);
    std::string many = "[";
    for (int i = 0; i < 2100000; ++i)
        many += "0,";
    EXPECT_NE(refused(many + "0]").find("more than 2000000 values"), std::string::npos);
    EXPECT_LT(memory_MiB() - before_MiB, 100.0);
}

TEST_F(HostileModel, GoesNowhereInCircles)
{
    GltfModel model = GltfModel::triangle();
    model.json["nodes"][0]["children"] = {1};
    model.json["nodes"].push_back({{"children", {0}}});
    EXPECT_NE(refused(model.gltf()).find("or below itself"), std::string::npos);
    GltfModel chain = GltfModel::triangle();
    for (int i = 1; i < 50000; ++i)
    {
        chain.json["nodes"][static_cast<std::size_t>(i - 1)]["children"] = {i};
        chain.json["nodes"].push_back(GltfModel::Json::object());
    }
    EXPECT_NE(refused(chain.gltf()).find("more than 200 deep"), std::string::npos);
    GltfModel shared = GltfModel::triangle();
    shared.json["nodes"] = {{{"children", {1, 1}}}, {{"mesh", 0}}};
    EXPECT_NE(refused(shared.gltf()).find("should be trees"), std::string::npos);
}
