#include "samples/installations/shell/InstallationOptions.h"
#include "samples/installations/shell/Looks.h"
#include "samples/installations/shell/MuteMemory.h"
#include "samples/installations/shell/ServiceNotifier.h"
#include "samples/shared/views/Offscreen.h"
#include "tests/samples/installations/Run.h"

#include <osgDB/ReadFile>
#include <osgViewer/Viewer>

#include <array>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

using namespace midair::samples;

TEST(Hold, EachDeviceHasOne)
{
    EXPECT_EQ(withHold("sim:"), "sim:?hold=1s");
    EXPECT_EQ(withHold("usb:7?ramp=50ms"), "usb:7?ramp=50ms&hold=1s");
    EXPECT_EQ(withHold("usb:?hold=3s"), "usb:?hold=3s");
    EXPECT_EQ(withHold("usb:A?boards=0-7,usb:B?boards=8-15"),
              "usb:A?boards=0-7&hold=1s,usb:B?boards=8-15&hold=1s");
    EXPECT_EQ(withHold("usb:?hold=2s,record:a,b.bin"), "usb:?hold=2s,record:a,b.bin?hold=1s");
    EXPECT_EQ(withHold("play:f?to=usb:A,usb:B"), "play:f?to=usb:A,usb:B&hold=1s")
        << "the list behind to= is one device's";
}

TEST(EarChoice, IsNeededForAllButSimulators)
{
    for (const char* simulated : {"sim:", "sim:?board=autd3&units=1", "null:", "sim:,null:"})
        EXPECT_TRUE(isSimulated(simulated)) << simulated;
    for (const char* real :
         {"usb:", "autd3:", "sim:,usb:", "record:f", "play:f?to=sim:", "booth", ""})
        EXPECT_FALSE(isSimulated(real)) << real;
    osgMidair::HapticSettings settings;
    settings.device = "usb:";
    InstallationOptions options;
    EXPECT_NE(whyEarLimitIsMissing(settings, options).find("\"usb:\""), std::string::npos);
    settings.earLimit = 100.0; // of a scene or of the installation: no operator's word
    EXPECT_FALSE(whyEarLimitIsMissing(settings, options).empty());
    options.settings = {{"earLimit", "none"}};
    EXPECT_EQ(whyEarLimitIsMissing(settings, options), "");
    options.settings.clear();
    settings.device = "sim:";
    EXPECT_EQ(whyEarLimitIsMissing(settings, options), "");
}

// What is told to be left is what the pipeline's own rule leaves.
TEST(EarChoice, SaysWhatEachLimitWouldLeave)
{
    osgMidair::HapticSettings settings;
    settings.array = "autd3";
    EarNeedMeter meter(settings);
    std::vector<std::complex<float>> full(249);
    for (std::size_t i = 0; i < full.size(); ++i)
        full[i] = std::polar(1.0F, 2.4F * static_cast<float>(i * i));
    meter.add({full});
    const EarNeed need = meter.need();
    EXPECT_FALSE(need.isFullDrive);
    EXPECT_NEAR(need.radius_m, 0.5, 1e-9);
    EXPECT_GT(need.level_dB, 130.0);
    EXPECT_NEAR(need.workersShare / need.publicShare, std::sqrt(10.0), 1e-6);
    // The loudest beam is over the limit by as many dB as the share is below 1.
    EXPECT_LE(-20.0 * std::log10(need.publicShare), need.level_dB - 100.0 + 6.7);
    EXPECT_GE(-20.0 * std::log10(need.publicShare), need.level_dB - 100.0 - 0.1);
    const std::string text = describe(need, settings.array);
    for (const char* told : {"array \"autd3\"",
                             "earLimit=100   the limit for the public: ",
                             "earLimit=110   the limit for workers: ",
                             "earLimit=none",
                             "OSG_MIDAIR_EAR_LIMIT"})
        EXPECT_NE(text.find(told), std::string::npos) << text;
    EarNeedMeter nothing(settings);
    EXPECT_TRUE(nothing.need().isFullDrive);
    EXPECT_GT(nothing.need().level_dB, 120.0);
}

TEST(EarChoice, NoInstallationStartsWithoutOne)
{
    const OwnFolder out("unchosen");
    for (const char* name : {"toybox", "piano", "water", "desk", "gallery", "paper-scenes", "jnd"})
    {
        const std::string file = out.path + "/" + name + ".midair";
        const std::string results =
            name == std::string("jnd") ? " --participant 1 --results '" + out.path + "/r.csv'" : "";
        const Visit refused =
            visit(name, "--frames 5 --device 'record:" + file + "'" + results, out);
        EXPECT_EQ(refused.outcome.code, 1) << name << refused.outcome.output;
        EXPECT_NE(refused.outcome.output.find("% of the pressure"), std::string::npos)
            << name << refused.outcome.output;
        EXPECT_FALSE(std::filesystem::exists(file)) << name << " opened it";
        EXPECT_FALSE(std::filesystem::exists(out.path + "/r.csv")) << "a rehearsal keeps nothing";
    }
    const std::string file = out.path + "/chosen.midair";
    const Visit none =
        visit("toybox", "--frames 5 --set earLimit=none --device 'record:" + file + "'", out);
    EXPECT_EQ(none.outcome.code, 0) << none.outcome.output;
    EXPECT_TRUE(std::filesystem::exists(file));
    std::filesystem::remove(file);
    const Outcome users = shell(std::string("OSG_MIDAIR_EAR_LIMIT=100 '") + MIDAIR_BIN +
                                "/midair-toybox' --headless --pictures 0 --frames 5 --out '" +
                                out.path + "' --device 'record:" + file + "'");
    EXPECT_EQ(users.code, 0) << users.output;
    const Outcome above =
        shell(std::string("OSG_MIDAIR_DEVICE='record:") + file + ".2' '" + MIDAIR_BIN +
              "/midair-toybox' --headless --pictures 0 --frames 5 " + "--out '" + out.path + "'");
    EXPECT_EQ(above.code, 1) << "the variable stands above the option";
    EXPECT_FALSE(std::filesystem::exists(file + ".2"));
}

TEST(MuteMemory, WhatWasMutedStaysMuted)
{
    const OwnFolder folder("mute");
    const std::string file = folder.path + "/desk.json";
    {
        MuteMemory first(file, 1000.0);
        EXPECT_FALSE(first.startsMuted());
        EXPECT_TRUE(first.keep(true));
        EXPECT_TRUE(first.end());
    }
    MuteMemory second(file, 2000.0);
    EXPECT_TRUE(second.startsMuted());
    EXPECT_NE(second.reason().find("muted"), std::string::npos) << second.reason();
    EXPECT_EQ(second.crashes(), 0);
    EXPECT_TRUE(second.keep(false));
    EXPECT_TRUE(second.end());
}

/// What a program leaves behind that was killed once it ran.
void runAndDie(const std::string& file, double now_s)
{
    MuteMemory killed(file, now_s);
    EXPECT_FALSE(killed.startsMuted());
    EXPECT_TRUE(killed.begin());
}

TEST(MuteMemory, WhoeverWasKilledHasCrashed)
{
    const OwnFolder folder("killed");
    const std::string file = folder.path + "/desk.json";
    runAndDie(file, 2000.0);
    const MuteMemory next(file, 2001.0);
    EXPECT_FALSE(next.startsMuted());
    EXPECT_EQ(next.crashes(), 1);
}

// As on a computer whose display isn't up yet: nothing has played, so nothing has crashed.
TEST(MuteMemory, AStartThatFailsIsNoCrash)
{
    const OwnFolder folder("starts");
    const std::string file = folder.path + "/desk.json";
    for (int i = 0; i < 20; ++i)
        EXPECT_EQ(MuteMemory(file, 1e9 + 2.0 * i).crashes(), 0) << i;
    runAndDie(file, 1e9 + 50.0);
    for (int i = 0; i < 20; ++i)
        EXPECT_EQ(MuteMemory(file, 1e9 + 51.0 + i).crashes(), 1) << i;
}

TEST(MuteMemory, AFileHasOneProgram)
{
    const OwnFolder folder("two");
    const std::string file = folder.path + "/desk.json";
    {
        MuteMemory first(file, 1000.0);
        first.begin();
        EXPECT_THROW(MuteMemory(file, 1000.0), std::runtime_error);
        EXPECT_TRUE(first.end());
    }
    EXPECT_EQ(MuteMemory(file, 1001.0).crashes(), 0);
}

TEST(MuteMemory, ThreeCrashesInTenMinutesMute)
{
    const OwnFolder folder("crashes");
    const std::string file = folder.path + "/desk.json";
    for (const double start_s : {0.0, 10.0, 20.0})
        runAndDie(file, 1e9 + start_s);
    {
        MuteMemory fourth(file, 1e9 + 30.0);
        fourth.begin();
        EXPECT_TRUE(fourth.startsMuted());
        EXPECT_EQ(fourth.reason(), "it crashed 3 times in 10 minutes");
        fourth.keep(false); // whoever lets it play has looked
        EXPECT_EQ(fourth.crashes(), 0);
    }
    EXPECT_FALSE(MuteMemory(file, 1e9 + 40.0).startsMuted());
    EXPECT_FALSE(MuteMemory(file, 1e9 + 2000.0).startsMuted()); // the others are long ago
}

TEST(MuteMemory, WhatIsNotUnderstoodMutes)
{
    const OwnFolder folder("broken");
    const std::string file = folder.path + "/desk.json";
    for (const char* text : {"", "{", "{\"muted\": 1}", "{\"muted\":false,\"running\":false}"})
    {
        std::ofstream(file) << text;
        const MuteMemory memory(file, 1000.0);
        EXPECT_TRUE(memory.startsMuted()) << text;
        EXPECT_NE(memory.reason().find("\"" + file + "\""), std::string::npos) << text;
    }
    const MuteMemory none(folder.path + "/none/desk.json", 1000.0);
    EXPECT_FALSE(none.startsMuted());
    EXPECT_NE(none.reason().find("can't be written"), std::string::npos);
}

TEST(ServiceNotifier, TellsSystemdThatFramesGoOn)
{
    const OwnFolder folder("notify");
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    const std::string path = folder.path + "/socket";
    std::memcpy(address.sun_path, path.c_str(), path.size());
    const int listener = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    ASSERT_EQ(::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
    ::setenv("WATCHDOG_USEC", "3000000", 1);
    const auto received = [&]
    {
        std::array<char, 256> text{};
        const ssize_t size = ::recv(listener, text.data(), text.size(), 0);
        return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "";
    };
    ServiceNotifier service;
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
    service.beat(10.0, "playing");
    EXPECT_EQ(received(), "READY=1\nWATCHDOG=1\nSTATUS=playing");
    service.beat(10.5, "playing");
    EXPECT_EQ(received(), ""); // not in every frame
    service.beat(11.0, "muted");
    EXPECT_EQ(received(), "WATCHDOG=1\nSTATUS=muted");
    service.stop();
    EXPECT_EQ(received(), "STOPPING=1");
    ::close(listener);
}

// What visitors see says how to mute, and that it is muted, in the upper right corner.
TEST(VisitorSign, ShowsTheMuteInPlainViews)
{
    const OwnFolder out("sign");
    const auto redPixels = [&](const std::string& more)
    {
        const Outcome run = shell(std::string("'") + MIDAIR_BIN +
                                  "/midair-desk' --headless --plain --frames 4 --pictures 1 "
                                  "--window 600x400 --out '" +
                                  out.path + "' " + more);
        EXPECT_EQ(run.code, 0) << run.output;
        const osg::ref_ptr<osg::Image> image = osgDB::readRefImageFile(out.path + "/desk_1.png");
        if (!image) return -1;
        int red = 0;
        for (int y = image->t() - 40; y < image->t(); ++y)
            for (int x = image->s() / 2; x < image->s(); ++x)
            {
                const osg::Vec4 color = image->getColor(x, y);
                if (color.r() > 0.6F && color.g() < 0.55F && color.b() < 0.45F) ++red;
            }
        return red;
    };
    const int muted = redPixels("--muted");
    if (muted < 0) GTEST_SKIP() << "no OpenGL without a display";
    EXPECT_GT(muted, 100);
    EXPECT_EQ(redPixels(""), 0);
}

// Letters follow the window's height, are readable in a small one, and no line leaves it.
TEST(VisitorSign, FollowsTheWindow)
{
    VisitorSign sign;
    sign.setInvitation("Touch the keys: each vibrates with its own note");
    sign.setCaption("E   139 Hz");
    const auto pixelsOfUnit = [&](double width, double height)
    {
        sign.update(width, height);
        // Of the letters, in the window: the camera maps units to -1 .. 1.
        const auto* camera = dynamic_cast<const osg::Camera*>(sign.node()->asGroup()->getChild(0));
        EXPECT_LT(sign.height(), 0.25F) << width;
        return 0.5 * height * camera->getProjectionMatrix()(1, 1);
    };
    EXPECT_NEAR(26.0 * pixelsOfUnit(640, 480), 16.0, 1e-3) << "the small letters";
    EXPECT_NEAR(pixelsOfUnit(1200, 800), 0.8, 1e-6);
    EXPECT_NEAR(pixelsOfUnit(1920, 1080), 1.08, 1e-6);
    const double wide = pixelsOfUnit(640, 480);
    EXPECT_LT(pixelsOfUnit(240, 480), 0.7 * wide) << "the line fits into the window";
    sign.setCaption("");
    sign.update(640, 480);
    const float without = sign.height();
    sign.setCaption("E   139 Hz");
    EXPECT_GT(sign.height(), without);
}

// A tracker that sees nobody, from the first frame on: the array is open, and silent.
TEST(Visitors, NothingSoundsBeforeAHandIsSeen)
{
    const OwnFolder out("nobody");
    for (const char* hands : {"--hands openxr:", "--set hands=openxr:"})
    {
        const Visit run = visit("toybox", std::string("--frames 120 --toss 0 ") + hands, out);
        ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
        EXPECT_EQ(run.report.at("framesPlaying"), 0) << hands;
        EXPECT_EQ(run.report.at("silence").at("framesAlone"), 120) << hands;
        EXPECT_EQ(run.report.at("device").get<std::string>().find("sim: 3984"), 0U) << hands;
    }
}

// A picture into a pipe that nobody reads makes frames hang. What was muted meanwhile stays muted,
// however the program ends.
TEST(MuteMemory, AMuteIsFollowedAndKeptWhileFramesHang)
{
    osgViewer::Viewer viewer;
    std::string problem;
    if (!setUpOffscreen(viewer, 64, 64, 30.0, &problem)) GTEST_SKIP() << problem;
    const OwnFolder out("hang");
    const Outcome run = shell(
        "( cd '" + out.path + "' && mkfifo water_1.png && { '" MIDAIR_BIN +
        "/midair-water' --headless --frames 6000 --pictures 600 --out . --state state.json & p=$!; "
        "for i in $(seq 300); do grep -q '\"running\":true' state.json && break; sleep 0.1; done; "
        "sleep 2; kill -USR1 $p; "
        "for i in $(seq 50); do grep -q '\"muted\":true' state.json && break; sleep 0.1; done; "
        "kill -KILL $p; wait $p; } ; cat state.json )");
    EXPECT_NE(run.output.find("\"muted\":true,\"running\":true"), std::string::npos) << run.output;
}
