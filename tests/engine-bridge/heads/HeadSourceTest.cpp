#include "engine-bridge/heads/HeadSource.h"

#include "engine-bridge/hands/HandSource.h"
#include "engine-bridge/heads/HeadOpening.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/hands/WrittenHands.h"

#include <cstdio>
#include <fstream>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>
#include <unistd.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

std::string openingError(const std::string& text, const std::vector<std::string>& more = {})
{
    try
    {
        openHead(text, more);
    }
    catch (const std::runtime_error& error)
    {
        return error.what();
    }
    return {};
}

/// Two heads, the second 0.1 s later, 0.1 m along x and turned by a right angle about z.
const char* const kHeads = "0,0,head,0,0,0.4,0,0,0,1,0,1,1\n"
                           "0.1,0,head,0.1,0,0.4,0,0,0.70710678,0.70710678,0,1,1\n";

RecordedHeadSource recorded(const std::string& text, bool loops = false)
{
    std::istringstream in(text);
    return RecordedHeadSource(in, "heads.csv", loops);
}

std::string recordedError(const std::string& text)
{
    try
    {
        recorded(text);
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return {};
}

} // namespace

TEST(HeadSource, AFixedOneLooksAtTheWorldsOrigin)
{
    const auto fixed = openHead("fixed 0 -0.3 0.4");
    ASSERT_TRUE(fixed);
    Head head;
    ASSERT_TRUE(fixed->headAt(7.0, head));
    EXPECT_TRUE(head.isTracked);
    EXPECT_EQ(head.time_s, 7.0);
    EXPECT_LT((head.pose.translation() - Vector3d(0, -0.3, 0.4)).norm(), 1e-12);
    EXPECT_LT((head.pose * Vector3d(0, 0, -0.5)).norm(), 1e-12) << "ahead";
    EXPECT_LT((head.pose.linear().col(0) - Vector3d::UnitX()).norm(), 1e-12) << "right";
    EXPECT_GT(head.pose.linear()(2, 1), 0.0) << "up";
    EXPECT_NEAR(head.pose.linear().determinant(), 1.0, 1e-12);
    EXPECT_TRUE(fixed->setHorizon(0.1));
    EXPECT_EQ(fixed->status(), "head fixed at 0 -0.3 0.4 m");
    for (const Vector3d& place : {Vector3d(0, 0, 0.5), Vector3d(0, 0, -1), Vector3d(0, 0, 0)})
    {
        const Eigen::Isometry3d pose = FixedHeadSource::upright(place);
        EXPECT_NEAR(pose.linear().determinant(), 1.0, 1e-12) << place.transpose();
        EXPECT_TRUE(pose.linear().isUnitary(1e-12)) << place.transpose();
    }
}

TEST(HeadSource, WhatIsNoKindIsRefusedByName)
{
    EXPECT_EQ(openingError("fixd 0 0 1"),
              "head source \"fixd 0 0 1\" is not known (did you mean fixed?); fixed X Y Z, "
              "recorded:FILE, recorded:FILE?loop, tag:FILE, openxr: and osc: are");
    EXPECT_NE(openingError("opnxr:", {"mouse:"}).find("(did you mean openxr?)"), std::string::npos);
    EXPECT_NE(
        openingError("telepathy:", {"mouse:"}).find(" mouse:, tag:FILE, openxr: and osc: are"),
        std::string::npos);
    EXPECT_EQ(openingError("tag:"),
              "head source \"tag:\": should be tag:FILE, where FILE describes camera and tags");
    EXPECT_NE(openingError("fixed:0 0 1"), "");
    for (const char* text : {"fixed 0 0", "fixed 0 0 nan", "fixed 0 0 1 2", "fixed 0 0 1001"})
        EXPECT_EQ(openingError(text),
                  std::string("head source \"") + text +
                      "\": should be fixed X Y Z: the midpoint between the eyes in the scene's "
                      "world, metres, each within 1000");
    EXPECT_NE(openingError("openxr:?spice=1"), "");
    EXPECT_NE(openingError("openxr:?process=helper").find("process=helper"), std::string::npos);
    EXPECT_NE(openingError("osc:?port=0"), "");
    EXPECT_FALSE(openHead(""));
    EXPECT_FALSE(openHead("none"));
}

TEST(HeadSource, OnesOwnIsOpenedByItsName)
{
    std::string error;
    ASSERT_TRUE(registerHeads(
        "own-head",
        [](const std::string& options) -> std::shared_ptr<HeadSource>
        {
            if (options == "throw") throw 7;
            if (options == "none") return nullptr;
            return std::make_shared<FixedHeadSource>(Eigen::Isometry3d::Identity());
        },
        error))
        << error;
    EXPECT_TRUE(isOwnHead("own-head:x"));
    EXPECT_TRUE(openHead("own-head:x"));
    EXPECT_NE(openingError("own-head:throw"), "");
    EXPECT_EQ(openingError("own-head:none"), "head source \"own-head:none\": it could not be made");
    EXPECT_FALSE(registerHeads(
        "openxr", [](const std::string&) { return nullptr; }, error));
    EXPECT_EQ(error, "the name \"openxr\" is taken");
}

TEST(HeadSource, AnInjectedOneIsLostWithTime)
{
    InjectedHeadSource source;
    Head head;
    EXPECT_FALSE(source.headAt(0.0, head));
    Head given;
    given.time_s = 1.0;
    given.isTracked = true;
    given.pose.translation() = Vector3d(0, 0, 0.5);
    source.set(given);
    EXPECT_TRUE(source.headAt(1.2, head));
    EXPECT_EQ(head.pose.translation().z(), 0.5);
    EXPECT_FALSE(source.headAt(1.21, head));
    EXPECT_FALSE(source.headAt(std::numeric_limits<double>::quiet_NaN(), head));
    source.clear();
    EXPECT_FALSE(source.headAt(1.0, head));
    EXPECT_EQ(source.status(), "head set by the application, 1 so far");
}

TEST(HeadSource, ARecordedOneIsBetweenTwo)
{
    RecordedHeadSource source = recorded(kHeads);
    Head head;
    ASSERT_TRUE(source.headAt(0.05, head));
    EXPECT_EQ(head.time_s, 0.05);
    EXPECT_LT((head.pose.translation() - Vector3d(0.05, 0, 0.4)).norm(), 1e-7);
    EXPECT_NEAR(Eigen::AngleAxisd(head.pose.linear()).angle(), 0.25 * base::kPi, 1e-6);
    EXPECT_TRUE(source.headAt(0.0, head));
    EXPECT_TRUE(source.headAt(0.1, head));
    EXPECT_FALSE(source.headAt(0.11, head));
    EXPECT_FALSE(source.headAt(-0.01, head));
    RecordedHeadSource looped = recorded(kHeads, true);
    ASSERT_TRUE(looped.headAt(1.05, head));
    EXPECT_NEAR(head.pose.translation().x(), 0.05, 1e-7);
    RecordedHeadSource gap = recorded("0,0,head,0,0,0,0,0,0,1,0,1,1\n"
                                      "0.1,0,head,0,0,0,0,0,0,1,0,0,1\n"
                                      "1,0,head,0,0,0,0,0,0,1,0,1,1\n");
    for (const double time_s : {0.05, 0.1, 0.5})
        EXPECT_FALSE(gap.headAt(time_s, head)) << time_s;
    EXPECT_TRUE(gap.headAt(1.0, head));
}

TEST(HeadSource, ARecordingHoldsHandsAndHeads)
{
    HandFrame frame;
    frame.hands.push_back(
        openHandWithIndexTipAt(1, Vector3d(0, 0, 0.2), Eigen::Quaterniond::Identity()));
    std::ostringstream written;
    writeHandRecording(written, {frame});
    const std::string both = written.str() + kHeads;
    EXPECT_EQ(recorded(both).heads().size(), 2u);
    std::istringstream in(both);
    const RecordedHandSource hands(in, "both.csv");
    ASSERT_EQ(hands.frames().size(), 1u);
    EXPECT_EQ(hands.frames()[0].hands.size(), 1u);
    EXPECT_EQ(recordedError(written.str()).rfind("heads.csv: no head in it; a line is time_s,", 0),
              0u);
    EXPECT_EQ(recordedError("1,0,head,0,0,0,0,0,0,1,0,1,1\n1,0,head,0,0,0,0,0,0,1,0,1,1\n"),
              "heads.csv, line 2: time 1 isn't after that of the head above it");
    EXPECT_EQ(recordedError("0,0,head,0,0,0,0,0,0,2,0,1,1\n"),
              "heads.csv, line 1: the quaternion's length is not 1");
}

TEST(HeadSource, ARecordingIsReadBesideTheFramesAndBeginsWithTheFirst)
{
    const std::string file = "heads-" + std::to_string(::getpid()) + ".csv";
    std::ofstream(file) << kHeads;
    OpeningHead source([&] { return openHead("recorded:" + file); }, file);
    Head head;
    EXPECT_TRUE(eventually([&] { return source.headAt(40.0, head); }));
    EXPECT_TRUE(source.headAt(40.05, head));
    EXPECT_NEAR(head.pose.translation().x(), 0.05, 1e-7);
    EXPECT_EQ(head.time_s, 40.05);
    OpeningHead missing([] { return openHead("recorded:nowhere.csv"); }, "nowhere.csv");
    std::vector<std::string> told;
    EXPECT_TRUE(eventually(
        [&]
        {
            missing.headAt(0.0, head);
            told = missing.takeMessages();
            return !told.empty();
        }));
    EXPECT_EQ(told.at(0),
              "\"hand recording \"nowhere.csv\" can't be read: No such file or directory\"");
    EXPECT_EQ(missing.status(), "nowhere.csv: not open");
    std::remove(file.c_str());
}

} // namespace midair::bridge
