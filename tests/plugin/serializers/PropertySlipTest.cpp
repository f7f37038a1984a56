// Names and values in text files that aren't any: nothing is lost in silence, and what may concern
// safety silences the scene. Units and spellings are known.
#include "tests/plugin/serializers/PropertyText.h"

#include <filesystem>
#include <fstream>

#include <unistd.h>

using namespace property_text;

namespace
{

struct Slip
{
    Written written;
    bool silences;
    std::string told;
};

template<class N>
bool isSilenced(const N& node)
{
    if constexpr (std::is_same_v<N, HapticScene>)
        return node.getSettings().isSilenced && !node.getSettings().whySilenced.empty();
    else
        return !node.getProperty().whySilenced.empty();
}

/// A known name on each side of a slip is read, the slip is told once with its line, and the node
/// silences its scene if it has to.
template<class N>
void expectTold(const Slip& slip, const Written& before, const Written& after)
{
    for (const bool isXml : {false, true})
    {
        Notices notices;
        const osg::ref_ptr<N> node = through<N>({before, slip.written, after}, isXml);
        ASSERT_NE(node, nullptr);
        const osg::ref_ptr<N> right = through<N>({before, after}, isXml);
        const std::string place = isXml ? "line 9: " : "line 9: ";
        const std::string said = "osgMidair: " + place + nameOf<N>();
        EXPECT_EQ(notices.text().find(said), 0u) << notices.text();
        const std::size_t told = notices.text().find(slip.told);
        EXPECT_NE(told, std::string::npos) << slip.told << "\n" << notices.text();
        EXPECT_EQ(notices.text().find(slip.told, told + 1), std::string::npos) << "once";
        EXPECT_EQ(isSilenced(*node), slip.silences) << slip.told;
        auto state = stateOf(*node);
        state.whySilenced.clear();
        if constexpr (std::is_same_v<N, HapticScene>) state.isSilenced = false;
        EXPECT_TRUE(state == stateOf(*right)) << slip.told;
    }
}

} // namespace

TEST(PropertySlip, InASceneIsToldAndSilencesItWhereItConcernsSafety)
{
    const Slip slips[] = {
        {scalar("MaxPresure", "500"), true, "\"MaxPresure\" (did you mean MaxPressure?)"},
        {scalar("enabeld", "FALSE"), true, "\"enabeld\" (did you mean Enabled?)"},
        {scalar("Devise", "\"usb:\""), true, "\"Devise\" (did you mean Device?)"},
        {scalar("Claibration", "1"), true, "\"Claibration\" (did you mean Calibration?)"},
        {scalar("NodeMsak", "0x0"), true, "\"NodeMsak\" (did you mean NodeMask?)"},
        {scalar("Quirk", "5"), true, "unknown property \"Quirk\""},
        {scalar("MaxPressure", "eight"),
         true,
         "MaxPressure can't be \"eight\", should be a number"},
        {scalar("MaxPressure", "1e999"), true, "MaxPressure can't be \"1e999\""},
        {scalar("MaxPressure", "nan"), true, "MaxPressure can't be \"nan\""},
        {scalar("MaxPressure", "500,0"), true, "MaxPressure can't be \"500,0\""},
        {scalar("MaxAmplitude", "50mm"), true, "MaxAmplitude can't be \"50mm\""},
        {scalar("MaxPressure", "1e99"), true, "MaxPressure is \"1e99\", should be a number, 0 .. "},
        {scalar("Cycle", "-3"), false, "Cycle is \"-3\", should be "},
        {scalar("Enabled", "maybe"), true, "Enabled can't be \"maybe\", should be true or false"},
        {scalar("Cylce", "4"), false, "\"Cylce\" (did you mean Cycle?)"},
        {scalar("Threads", "many"), false, "Threads can't be \"many\", should be a number"},
        {scalar("PhaseOnly", "perhaps"), false, "PhaseOnly can't be \"perhaps\""}};
    for (const Slip& slip : slips)
        expectTold<HapticScene>(slip, scalar("Even", "40"), scalar("Name", "\"behind it\""));
}

TEST(PropertySlip, InASurfaceIsToldAndSilencesTheSceneWhereItConcernsSafety)
{
    const Slip slips[] = {
        {scalar("Presure", "500"), true, "\"Presure\" (did you mean Pressure?)"},
        {scalar("Enabled", "flase"), true, "Enabled can't be \"flase\""},
        {scalar("Pressure", "500,0"), true, "Pressure can't be \"500,0\""},
        {scalar("PressureUnit", "PSI"), true, "PressureUnit can't be \"PSI\""},
        {scalar("Spacing", "-3"), false, "Spacing is \"-3\", should be "},
        {scalar("Pressure", "-500"), true, "Pressure is \"-500\", should be "},
        {scalar("Samplng", "EDGES"), false, "\"Samplng\" (did you mean Sampling?)"},
        {scalar("Sampling", "EGDES"),
         false,
         "Sampling can't be \"EGDES\", should be one of surface, edges, vertices (did you mean "
         "EDGES?)"}};
    for (const Slip& slip : slips)
        expectTold<HapticSurface>(slip, scalar("Priority", "3"), scalar("Side", "BACK"));
}

TEST(PropertySlip, AListThatIsNotAsLongAsItSaysSilences)
{
    const Slip slips[] = {
        {{"Points", "2 { 0 0 0.01 }", "attribute=\"2\" text=\"0 0 0.01\" />"}, true, "3 numbers"},
        {{"Pressures", "1 { loud }", "attribute=\"1\" text=\"loud\" />"},
         true,
         "\"loud\" should be a number"}};
    for (const Slip& slip : slips)
        expectTold<HapticPoints>(slip, scalar("Priority", "3"), scalar("Spacing", "0.5"));
}

// What is written as in other notations: OSG takes the sign for the value.
TEST(PropertySlip, AValueBehindASignIsToldInOnePairOfQuotes)
{
    Notices notices;
    const auto scene =
        through<HapticScene>({scalar("Array", "= \"my octagon\""), scalar("Cycle", "4")}, false);
    ASSERT_NE(scene, nullptr);
    EXPECT_TRUE(isSilenced(*scene));
    EXPECT_EQ(scene->getCycle(), 4) << "what follows is read";
    EXPECT_NE(notices.text().find("line 8: HapticScene: the text \"my octagon\""),
              std::string::npos)
        << notices.text();
}

TEST(PropertySlip, OfASceneTwiceIsUnclear)
{
    const List twice = {scalar("MaxPressure", "500"), scalar("MaxPressure", "5000")};
    for (const bool isXml : {false, true})
    {
        Notices notices;
        const auto scene = through<HapticScene>(twice, isXml);
        ASSERT_NE(scene, nullptr);
        EXPECT_TRUE(isSilenced(*scene));
        EXPECT_NE(notices.text().find("MaxPressure occurs twice"), std::string::npos);
    }
}

TEST(PropertySlip, InPlaceOfTheUniqueIdSilences)
{
    Notices notices;
    const auto node = parsed("#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n\n"
                             "osgMidair::HapticScene { MaxPressure 500 UniqueID 1 Cycle 4 }\n",
                             false);
    const auto* scene = dynamic_cast<const HapticScene*>(node.get());
    ASSERT_NE(scene, nullptr);
    EXPECT_TRUE(isSilenced(*scene));
    EXPECT_EQ(scene->getCycle(), 4);
    EXPECT_NE(notices.text().find("\"MaxPressure\" precedes UniqueID"), std::string::npos)
        << notices.text();
}

TEST(PropertySlip, AnUnknownNameDoesNotHideTheNextOnes)
{
    const List list = {
        scalar("Foo", "BAR"),
        {"Nest", "{ MaxPressure 3 { Cycle 9 } }", "><Cycle attribute=\"9\" /></Nest>"},
        scalar("Baz", "1 2 \"Cycle } 9\""),
        scalar("Cycle", "4")};
    for (const bool isXml : {false, true})
    {
        Notices notices;
        const auto scene = through<HapticScene>(list, isXml);
        ASSERT_NE(scene, nullptr);
        EXPECT_EQ(scene->getCycle(), 4);
        EXPECT_EQ(scene->getMaxPressure(), 0.0);
        for (const char* name : {"\"Foo\"", "\"Nest\"", "\"Baz\""})
            EXPECT_NE(notices.text().find(name), std::string::npos) << notices.text();
    }
}

TEST(PropertyValue, HasUnitsAndSpellings)
{
    const List list = {scalar("MaxPressure", "0.8 kPa"),
                       scalar("Enabled", "yes"),
                       scalar("PhaseOnly", "off"),
                       scalar("MaxAmplitude", "30%"),
                       scalar("Reach", "5cm"),
                       scalar("Deadline", "0.5 s"),
                       scalar("FieldRate", "2 kHz"),
                       scalar("Humidity", "\"40 %\"")};
    for (const bool isXml : {false, true})
    {
        Notices notices;
        const auto scene = through<HapticScene>(list, isXml);
        ASSERT_NE(scene, nullptr);
        EXPECT_EQ(scene->getMaxPressure(), 800.0);
        EXPECT_TRUE(scene->getEnabled());
        EXPECT_FALSE(scene->getPhaseOnly());
        EXPECT_EQ(scene->getMaxAmplitude(), 0.3);
        EXPECT_EQ(scene->getReach(), 0.05);
        EXPECT_EQ(scene->getSettings().deadline_ms, 500.0);
        EXPECT_EQ(scene->getFieldRate(), 2000.0);
        EXPECT_EQ(scene->getSettings().humidity, 0.4);
        EXPECT_EQ(notices.text(), "");

        const auto surface = through<HapticSurface>(
            {scalar("Pressure", "0.5 kPa"), scalar("Sampling", "Edges")}, isXml);
        ASSERT_NE(surface, nullptr);
        EXPECT_EQ(surface->getPressure(), 500.0);
        EXPECT_EQ(surface->getPressureUnit(), HapticProperty::PASCAL);
        EXPECT_EQ(surface->getSampling(), HapticProperty::EDGES);
    }
}

TEST(PropertySlip, NamesTheFile)
{
    findPlugins();
    const auto folder =
        std::filesystem::temp_directory_path() / ("midair-slip-" + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    for (const bool isXml : {false, true})
    {
        const std::string name = isXml ? "wrong.osgx" : "wrong.osgt";
        std::ofstream(folder / name)
            << fileOf("HapticScene", {scalar("Cycle", "4"), scalar("MaxPresure", "500")}, isXml);
        Notices notices;
        EXPECT_TRUE(osgDB::readRefNodeFile((folder / name).string()));
        EXPECT_EQ(notices.text(),
                  "osgMidair: " + name +
                      ":9: HapticScene: unknown property \"MaxPresure\" (did "
                      "you mean MaxPressure?); nothing is played until that is "
                      "right\n");
    }
    std::filesystem::remove_all(folder);
}

TEST(PropertySlip, IsNotSavedAsAPlayingScene)
{
    const auto scene = through<HapticScene>({scalar("MaxPresure", "500")}, false);
    ASSERT_NE(scene, nullptr);
    EXPECT_TRUE(scene->getEnabled());
    for (const char* type : {"Ascii", "XML", "Binary"})
    {
        Notices notices;
        osgDB::ReaderWriter& format =
            *osgDB::Registry::instance()->getReaderWriterForExtension("osgt");
        const osg::ref_ptr<osgDB::Options> options =
            new osgDB::Options(std::string("fileType=") + type);
        std::stringstream stream(std::ios::in | std::ios::out | std::ios::binary);
        ASSERT_TRUE(format.writeNode(*scene, stream, options).success());
        const osg::ref_ptr<osg::Node> read = format.readNode(stream, options).takeNode();
        ASSERT_TRUE(read);
        EXPECT_FALSE(dynamic_cast<HapticScene&>(*read).getEnabled()) << type;
    }
}

TEST(PropertySlip, OfAnObjectSilencesTheWholeScene)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil(
        [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; }));
    const auto wrong = through<HapticSurface>({scalar("Enabeld", "FALSE")}, false);
    ASSERT_NE(wrong, nullptr);
    wrong->addChild(BoxScene::box(0.01f));
    box.scene->addChild(wrong);
    EXPECT_TRUE(
        viewer.framesUntil([&] { return box.scene->getStatistics().state == ArrayState::SILENT; }));
    std::string all;
    for (const std::string& message : box.scene->getStatistics().messages)
        all += message + "\n";
    EXPECT_NE(all.find("unknown property \"Enabeld\""), std::string::npos) << all;
    box.scene->removeChild(wrong);
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; }));
}
