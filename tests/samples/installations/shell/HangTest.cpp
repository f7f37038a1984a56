// An installation whose frames hang ends when it is told to, and its array is silent before.
#include "device/recording/Recording.h"
#include "samples/installations/shell/Installation.h"
#include "tests/samples/Ending.h"
#include "tests/samples/installations/Run.h"

#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osg/Shape>
#include <osg/ShapeDrawable>

#include <iterator>
#include <vector>

using namespace midair::samples;

namespace
{

/// A box that plays, whether somebody is there or not, until a frame hangs.
class Hanging : public Installation
{
public:
    explicit Hanging(int to) : _to(to) {}
    InstallationTitle title() const override { return {"hanging", "A test.", "Nobody"}; }
    std::string arrayOf(const std::string&) const override { return "board"; }
    void build(Stage& stage) override
    {
        osg::ref_ptr<osg::MatrixTransform> at =
            new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.15));
        at->addChild(
            new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.04F))));
        stage.haptics.addChild(at);
    }
    void update(const Moment& now) override
    {
        if (now.statistics.state != osgMidair::ArrayState::PLAYING) return;
        EXPECT_EQ(::write(_to, "r", 1), 1);
        for (;;)
            ::pause();
    }
    bool restsAlone() const override { return false; }
    void report(nlohmann::ordered_json&) const override {}

private:
    const int _to;
};

} // namespace

TEST(InstallationThatHangs, EndsBySigtermSilentFirst)
{
    const OwnFolder folder("hanging");
    const std::string file = folder.path + "/show.recording";
    const Ending ending = endingOf(
        [&](int to)
        {
            Hanging installation(to);
            // Longer than it may take: the hold doesn't silence it.
            std::string words[] = {"midair-hanging",
                                   "--headless",
                                   "--pictures",
                                   "0",
                                   "--frames",
                                   "100000",
                                   "--out",
                                   folder.path,
                                   "--device",
                                   "record:" + file + "?hold=30s",
                                   "--set",
                                   "earLimit=none"};
            std::vector<char*> line;
            for (std::string& word : words)
                line.push_back(word.data());
            return runInstallation(installation, static_cast<int>(line.size()), line.data());
        },
        SIGTERM);
    EXPECT_EQ(ending.signal, SIGTERM);
    EXPECT_LT(ending.seconds, 2.0);
    namespace recording = midair::device::recording;
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    recording::Reader reader(bytes, file);
    recording::Entry entry;
    std::vector<recording::Kind> kinds;
    while (reader.next(entry) == recording::Stop::MORE)
        kinds.push_back(entry.kind);
    ASSERT_GE(kinds.size(), 2U);
    EXPECT_EQ(kinds.front(), recording::Kind::FIELD);
    EXPECT_EQ(kinds.back(), recording::Kind::SILENCE);
}
