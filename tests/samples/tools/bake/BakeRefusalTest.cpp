// What midair-bake doesn't take, and how it says so.

#include "tests/samples/tools/bake/BakedScene.h"

TEST_F(Baking, PartsOfOtherWorkOrWithGapsAreRefusedByName)
{
    const std::string a = frames("--shard 1/2 --out a.part");
    ASSERT_EQ(bake(a).code, 0);
    ASSERT_EQ(bake(frames("--shard 2/2 --out b.part")).code, 0);
    const auto refusal = [&](const std::string& parts)
    {
        const Outcome outcome = bake("--out merged.midair --merge " + parts);
        EXPECT_EQ(outcome.code, 2) << parts;
        EXPECT_FALSE(std::filesystem::exists(at("merged.midair")));
        return outcome.output;
    };
    EXPECT_EQ(refusal("a.part").find(
                  "midair-bake: 2 of 5 pieces are missing, the first of them frames 4 to 7;"),
              0u);
    std::filesystem::copy_file(at("a.part"), at("copy.part"));
    EXPECT_EQ(refusal("a.part b.part copy.part"),
              "midair-bake: frames 0 to 3 are in \"a.part\" and in \"copy.part\"\n");
    ASSERT_EQ(bake("scene.osgt --frames 0:20 --fps 20 --chunk 4 --shard 2/2 --out fps.part").code,
              0);
    EXPECT_EQ(refusal("a.part fps.part"),
              "midair-bake: \"a.part\" and \"fps.part\" are of different work: fps is 10.0 and "
              "20.0\n");
    write("scene.osgt", scene("Temperature 25 "));
    ASSERT_EQ(bake(frames("--shard 2/2 --out warm.part")).code, 0);
    EXPECT_NE(refusal("a.part warm.part").find("files.scene.osgt.bytes is"), std::string::npos);
    write("scene.osgt", scene());
    ASSERT_EQ(bake(frames("--shard 2/2 --out cap.part"), "OSG_MIDAIR_MAX_PRESSURE=200").code, 0);
    EXPECT_EQ(refusal("a.part cap.part"),
              "midair-bake: \"a.part\" and \"cap.part\" are of different work: "
              "settings.maxPressure is \"0\" and \"200\"\n");
    EXPECT_NE(refusal("scene.osgt").find("isn't a part"), std::string::npos);
}

TEST_F(Baking, APartOfOtherWorkIsNotGoneOnWith)
{
    ASSERT_EQ(bake(frames("--shard 1/2 --out a.part")).code, 0);
    const std::string before = read("a.part");
    const Outcome other = bake(frames("--shard 2/2 --out a.part"));
    EXPECT_EQ(other.code, 2);
    EXPECT_NE(other.output.find("other work: shard is 1 and 2"), std::string::npos) << other.output;
    const Outcome scene = bake(frames("--shard 1/2 --out scene.osgt"));
    EXPECT_EQ(scene.code, 2);
    EXPECT_NE(scene.output.find("isn't a part"), std::string::npos) << scene.output;
    const Outcome file = bake(frames("--out scene.osgt"));
    EXPECT_EQ(file.code, 2);
    EXPECT_NE(file.output.find("--overwrite"), std::string::npos) << file.output;
    EXPECT_TRUE(read("a.part") == before);
    EXPECT_EQ(read("scene.osgt"), Baking::scene());
}

TEST_F(Baking, WhatIsLiveIsRefusedByNameUnlessItIsLeftOut)
{
    write("scene.osgt",
          scene("Hands \"mouse:\" Render AUTO ",
                "osgParticle::ParticleSystemUpdater { UniqueID 9 Name \"dust\" }\n"));
    const Outcome outcome = bake(frames("--out a.midair"));
    EXPECT_EQ(outcome.code, 2);
    for (const char* part : {"hands \"mouse:\": ", "render is contact or auto", "'dust': "})
        EXPECT_NE(outcome.output.find(part), std::string::npos) << part << outcome.output;
    const Outcome without = bake(frames("--out a.midair --without-live"));
    EXPECT_EQ(without.code, 0) << without.output;
    EXPECT_EQ(entries("a.midair").size(), 20u);
}

TEST_F(Baking, WrongWordsAreToldWithWhatWouldBeRight)
{
    const auto says = [&](const std::string& arguments, const std::string& what)
    {
        const Outcome outcome = bake(arguments);
        EXPECT_EQ(outcome.code, 2) << arguments;
        EXPECT_NE(outcome.output.find(what), std::string::npos) << outcome.output;
    };
    says("--out a.midair", "--merge PARTS");
    says("scene.osgt --out a.midair", "--frames is \"\", should be A:B");
    says("scene.osgt --frames 5:5 --out a.midair", "--frames is \"5:5\"");
    says("scene.osgt --frames 0:1e30 --out a.midair", "--frames is \"0:1e30\"");
    says(frames("--shard 3/2 --out a.midair"), "--shard is \"3/2\"");
    says(frames(""), "--out FILE");
    says("nowhere.osgt --frames 0:2 --out a.midair", "can't read \"nowhere.osgt\"");
    says("scene.osgt --frames 0:2 --fps 0 --out a.midair", "0");
    write("scene.osgt", scene("MaxPressure much "));
    says(frames("--out a.midair"), "MaxPressure");
    write("scene.osgt", scene("Enabled FALSE "));
    says(frames("--out a.midair"), "enabled");
    write("scene.osgt", scene("Device \"sim:?max-amplitude=lots\" "));
    says(frames("--out a.midair"), "max-amplitude");
    EXPECT_FALSE(std::filesystem::exists(at("a.midair")));
}

TEST_F(Baking, SilenceIsToldAndHasACodeOfItsOwn)
{
    std::string far = scene();
    far.replace(far.find("0 0 0.15"), 8, "0 0 9.15");
    far.replace(far.find("0 0.03 0.15"), 11, "0 0.03 9.15");
    write("scene.osgt", far);
    const Outcome outcome = bake(frames("--out a.midair"));
    EXPECT_EQ(outcome.code, 1) << outcome.output;
    EXPECT_NE(outcome.output.find("20 of these frames are silent"), std::string::npos)
        << outcome.output;
    for (const auto& entry : entries("a.midair"))
        EXPECT_EQ(entry.kind, midair::device::recording::Kind::SILENCE);
}

TEST_F(Baking, AnEstimateWritesNothing)
{
    const Outcome outcome = bake(frames("--estimate"));
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("10^6 fields\n  on one core"), std::string::npos)
        << outcome.output;
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        files += entry.exists() ? 1 : 0;
    EXPECT_EQ(files, 1u);
}
