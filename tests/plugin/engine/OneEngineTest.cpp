// The kit, the C interface and Python play by one engine: the same calls in the same order give the
// same drives, states, touches and messages. Each plays on a recorder of its own.
#include "haptics/array/TransducerArray.h"
#include "haptics/base/text/MessageLog.h"
#include "tests/Eventually.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/DeviceDriver>
#include <osgMidair/HandSource>
#include <osgMidair/HapticStatistics>

#include <osg/FrameStamp>
#include <osg/Geometry>
#include <osg/ValueObject>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <random>
#include <sstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <midair.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace osgMidair;

namespace
{

/// What a device got last.
class Recorder
{
public:
    void begin(std::size_t transducers)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _transducers = transducers;
    }
    bool play(const std::uint8_t* phases, const std::uint8_t* amplitudes)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        if (_isLost) return false;
        _field.assign(phases, phases + _transducers);
        _field.insert(_field.end(), amplitudes, amplitudes + _transducers);
        return true;
    }
    void silence()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _field.clear();
    }
    void setLost(bool isLost)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _isLost = isLost;
        if (isLost) _field.clear();
    }
    bool isLost() const
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _isLost;
    }
    std::vector<std::uint8_t> field() const
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _field;
    }

private:
    mutable std::mutex _mutex;
    std::size_t _transducers = 0;
    bool _isLost = false;
    std::vector<std::uint8_t> _field; ///< phases, then amplitudes; empty: silence
};

Recorder ofKit;
Recorder ofC;

class KitDriver : public DeviceDriver
{
public:
    bool open(const std::string&,
              const std::map<std::string, std::string>&,
              const Layout& layout,
              std::string&) override
    {
        ofKit.begin(layout.transducers);
        return true;
    }
    bool play(const unsigned char* phases, const unsigned char* amplitudes) override
    {
        return ofKit.play(phases, amplitudes);
    }
    void silence() override { ofKit.silence(); }
    bool isReady() const override { return !ofKit.isLost(); }
};

void registerRecorders()
{
    static const bool isDone = []
    {
        std::string error;
        EXPECT_TRUE(registerDevice(
            "onekit", [] { return new KitDriver; }, error))
            << error;
        midair_driver driver{};
        driver.struct_size = sizeof(driver);
        driver.open =
            [](void*, const char*, const char*, const int32_t*, uint32_t transducers, char*, size_t)
            -> void*
        {
            ofC.begin(transducers);
            return &ofC;
        };
        driver.play = [](void*, const uint8_t* phases, const uint8_t* amplitudes)
        { return ofC.play(phases, amplitudes) ? 0 : 1; };
        driver.silence = [](void*)
        {
            ofC.silence();
            return 0;
        };
        driver.is_ready = [](void*) { return ofC.isLost() ? 0 : 1; };
        EXPECT_EQ(midair_register_device("onec", &driver), MIDAIR_OK) << midair_last_error();
        return true;
    }();
    (void)isDone;
}

/// What can be seen of a player once it has come to rest.
struct Seen
{
    std::vector<std::uint8_t> field;
    int state = 0;
    std::vector<std::string> touches; ///< sorted; with their forces
    std::vector<std::string> messages;
    std::uint64_t sent = 0; ///< fields; not compared

    bool operator==(const Seen& other) const
    {
        return field == other.field && state == other.state && touches == other.touches &&
               messages == other.messages;
    }
};

/// What is left of \a seen while a device is lost and after it: whether something sounds, who
/// touches, and what is told without its numbers. A field that isn't taken is solved again and
/// again by the clock, each time from the last one. Whether a field was refused before the loss was
/// seen is a matter of the clock, too.
Seen roughly(Seen seen)
{
    seen.field.resize(std::min<std::size_t>(seen.field.size(), 1), 0);
    std::fill(seen.field.begin(), seen.field.end(), 0);
    for (std::string& touch : seen.touches)
        touch.resize(3);
    seen.messages.erase(std::remove_if(seen.messages.begin(),
                                       seen.messages.end(),
                                       [](const std::string& message)
                                       { return message.rfind("device refused a field", 0) == 0; }),
                        seen.messages.end());
    for (std::string& message : seen.messages)
        message = midair::base::withoutNumbers(message);
    std::sort(seen.messages.begin(), seen.messages.end());
    return seen;
}

std::ostream& operator<<(std::ostream& out, const Seen& seen)
{
    std::uint32_t sum = 0;
    for (const std::uint8_t level : seen.field)
        sum = sum * 31 + level;
    return out << fmt::format("field of {} levels, sum {:x}; state {}; touches: {}; told: {}",
                              seen.field.size(),
                              sum,
                              seen.state,
                              fmt::join(seen.touches, ", "),
                              fmt::join(seen.messages, " | "));
}

/// Names that differ by who plays.
std::string withoutNames(std::string text)
{
    const std::pair<const char*, const char*> names[] = {{"onekit", "ONE"},
                                                         {"onec", "ONE"},
                                                         {"onepython", "ONE"},
                                                         {"scene/box", "BOX"},
                                                         {"object 1", "BOX"}};
    for (const auto& [from, to] : names)
        for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from))
            text.replace(at, std::strlen(from), to);
    return text;
}

constexpr float kHalf = 0.02F; ///< of the box's edge, m
constexpr float kCorners[8][3] = {{-kHalf, -kHalf, -kHalf},
                                  {kHalf, -kHalf, -kHalf},
                                  {kHalf, kHalf, -kHalf},
                                  {-kHalf, kHalf, -kHalf},
                                  {-kHalf, -kHalf, kHalf},
                                  {kHalf, -kHalf, kHalf},
                                  {kHalf, kHalf, kHalf},
                                  {-kHalf, kHalf, kHalf}};
constexpr std::uint32_t kTriangles[12][3] = {{0, 2, 1},
                                             {0, 3, 2},
                                             {4, 5, 6},
                                             {4, 6, 7},
                                             {0, 1, 5},
                                             {0, 5, 4},
                                             {1, 2, 6},
                                             {1, 6, 5},
                                             {2, 3, 7},
                                             {2, 7, 6},
                                             {3, 0, 4},
                                             {3, 4, 7}};

/// Half of a side of the reflector, and what else it is; exact in single precision.
constexpr float kHalfPlate_m[2] = {0.15625F, 0.125F};
constexpr const char* kPlateTag = "accuracy=0.2; reflection=0.75";

/// A scene with a box on an array, whoever plays it.
class Player
{
public:
    virtual ~Player() = default;
    virtual void set(const std::string& name, const std::string& value) = 0;
    virtual void setOfBox(const std::string& name, const std::string& value) = 0;
    virtual void move(double x_m) = 0;
    virtual void setHand(double z_m) = 0;  ///< of the index finger's tip; 0: no hand
    virtual void setPlate(double z_m) = 0; ///< a reflector over the box; 0: none
    virtual void setMuted(bool isMuted) = 0;
    virtual void setLost(bool isLost) = 0; ///< its device
    virtual void frame(double time_s) = 0;
    virtual bool isSettled() = 0;
    virtual Seen seen() = 0;
};

class KitPlayer : public Player
{
public:
    explicit KitPlayer(const std::string& array)
    {
        _scene->setName("scene");
        _scene->setArray(array);
        _scene->setDevice("onekit:");
        _scene->setFeelThreshold(1e-6); // how long a field is too weak is a matter of the clock
        _scene->setHandSource(_hands);
        osg::ref_ptr<osg::Geometry> mesh = new osg::Geometry;
        osg::ref_ptr<osg::Vec3Array> corners = new osg::Vec3Array;
        for (const auto& c : kCorners)
            corners->push_back({c[0], c[1], c[2]});
        osg::ref_ptr<osg::DrawElementsUInt> faces = new osg::DrawElementsUInt(GL_TRIANGLES);
        for (const auto& t : kTriangles)
            faces->insert(faces->end(), std::begin(t), std::end(t));
        mesh->setVertexArray(corners);
        mesh->addPrimitiveSet(faces);
        _box->setName("box");
        _box->setTouchEvents(true);
        _box->addChild(mesh);
        _place->addChild(_box);
        _scene->addChild(_place);
        _plate->setUserValue("reflector", std::string(kPlateTag));
        _plate->addChild(
            osg::createTexturedQuadGeometry(osg::Vec3(-kHalfPlate_m[0], -kHalfPlate_m[1], 0.0F),
                                            osg::Vec3(2.0F * kHalfPlate_m[0], 0.0F, 0.0F),
                                            osg::Vec3(0.0F, 2.0F * kHalfPlate_m[1], 0.0F)));
        move(0.0);
    }
    void set(const std::string& name, const std::string& value) override
    {
        HapticSettings settings = _scene->getSettings();
        std::string error;
        EXPECT_TRUE(settings.set(name, value, error)) << error;
        _scene->setSettings(settings);
    }
    void setOfBox(const std::string& name, const std::string& value) override
    {
        HapticProperty property = _box->getProperty();
        std::string error;
        EXPECT_TRUE(property.set(name, value, error)) << error;
        _box->setProperty(property);
    }
    void move(double x_m) override { _place->setMatrix(osg::Matrixd::translate(x_m, 0.0, 0.15)); }
    void setHand(double z_m) override
    {
        _hands->setHands(z_m > 0.0 ? std::vector<Hand>{openHand(1, {0.0, 0.0, z_m}, {})}
                                   : std::vector<Hand>());
    }
    void setPlate(double z_m) override
    {
        _scene->removeChild(_plate);
        if (z_m > 0.0) _scene->addChild(_plate);
        _plate->setMatrix(osg::Matrixd::translate(0.0, 0.0, z_m));
    }
    void setMuted(bool isMuted) override { _scene->setMuted(isMuted); }
    void setLost(bool isLost) override { ofKit.setLost(isLost); }
    void frame(double time_s) override
    {
        _stamp->setFrameNumber(_stamp->getFrameNumber() + 1);
        _stamp->setSimulationTime(time_s);
        _scene->update(_stamp);
    }
    bool isSettled() override
    {
        const HapticStatistics now = _scene->getStatistics();
        return now.processed >= now.snapshots && now.fields.waiting == 0;
    }
    Seen seen() override
    {
        Seen all;
        const HapticStatistics now = _scene->getStatistics();
        all.field = ofKit.field();
        all.state = static_cast<int>(now.state);
        all.sent = now.fields.sent;
        for (const Touch& touch : _scene->getTouches())
            all.touches.push_back(fmt::format("{} {} {:.6g} m {:.6g} N",
                                              touch.hand,
                                              static_cast<int>(touch.finger),
                                              touch.distance,
                                              touch.force));
        for (const std::string& message : now.messages)
            all.messages.push_back(withoutNames(message));
        std::sort(all.touches.begin(), all.touches.end());
        return all;
    }

private:
    osg::ref_ptr<HapticScene> _scene = new HapticScene;
    osg::ref_ptr<osg::MatrixTransform> _place = new osg::MatrixTransform;
    osg::ref_ptr<HapticSurface> _box = new HapticSurface;
    osg::ref_ptr<osg::MatrixTransform> _plate = new osg::MatrixTransform;
    osg::ref_ptr<InjectedHands> _hands = new InjectedHands;
    osg::ref_ptr<osg::FrameStamp> _stamp = new osg::FrameStamp;
};

/// The plate as JSON; "": none.
std::string plateAt(double z_m)
{
    if (!(z_m > 0.0)) return {};
    return fmt::format(R"({{"reflectors": [{{"position_m": [0, 0, {}], "normal": [0, 0, 1], )"
                       R"("along": [1, 0, 0], "size_m": [{}, {}], "accuracy_mm": 0.2, )"
                       R"("reflection": 0.75}}]}})",
                       z_m,
                       2.0 * kHalfPlate_m[0],
                       2.0 * kHalfPlate_m[1]);
}

class CPlayer : public Player
{
public:
    explicit CPlayer(const std::string& array)
    {
        EXPECT_EQ(midair_array_load(array.c_str(), &_array), MIDAIR_OK) << midair_last_error();
        EXPECT_EQ(midair_scene_make(_array, &_scene), MIDAIR_OK);
        std::vector<double> corners;
        for (const auto& c : kCorners)
            corners.insert(corners.end(), std::begin(c), std::end(c));
        EXPECT_EQ(midair_add_mesh(_scene, corners.data(), 8, &kTriangles[0][0], 12, nullptr, &_box),
                  MIDAIR_OK);
        setOfBox("touchEvents", "true");
        EXPECT_EQ(midair_set(_scene, "feelThreshold", "1e-6"), MIDAIR_OK);
        move(0.0);
        EXPECT_EQ(midair_play(_scene, "onec:"), MIDAIR_OK) << midair_last_error();
    }
    ~CPlayer() override
    {
        midair_scene_close(_scene);
        midair_array_close(_array);
    }
    CPlayer(const CPlayer&) = delete;
    CPlayer& operator=(const CPlayer&) = delete;

    void set(const std::string& name, const std::string& value) override
    {
        EXPECT_EQ(midair_set(_scene, name.c_str(), value.c_str()), MIDAIR_OK)
            << midair_last_error();
    }
    void setOfBox(const std::string& name, const std::string& value) override
    {
        EXPECT_EQ(midair_object_set(_scene, _box, name.c_str(), value.c_str()), MIDAIR_OK)
            << midair_last_error();
    }
    void move(double x_m) override
    {
        const double pose[16] = {1, 0, 0, x_m, 0, 1, 0, 0, 0, 0, 1, 0.15, 0, 0, 0, 1};
        EXPECT_EQ(midair_set_pose(_scene, _box, pose), MIDAIR_OK);
    }
    void setHand(double z_m) override { _hand_m = z_m; }
    void setPlate(double z_m) override
    {
        EXPECT_EQ(midair_set_reflectors(_scene, plateAt(z_m).c_str()), MIDAIR_OK)
            << midair_last_error();
    }
    void setMuted(bool isMuted) override { midair_mute(_scene, isMuted ? 1 : 0); }
    void setLost(bool isLost) override { ofC.setLost(isLost); }
    void frame(double time_s) override
    {
        const double tip[3] = {0.0, 0.0, _hand_m};
        const double upright[4] = {0.0, 0.0, 0.0, 1.0};
        midair_hand hand{};
        EXPECT_EQ(midair_make_hand(1, tip, upright, &hand), MIDAIR_OK);
        EXPECT_EQ(midair_set_hands(_scene, &hand, _hand_m > 0.0 ? 1 : 0), MIDAIR_OK);
        midair_update(_scene, time_s);
    }
    bool isSettled() override
    {
        midair_device_state now{};
        midair_state(_scene, &now);
        return now.waiting == 0;
    }
    Seen seen() override
    {
        Seen all;
        midair_device_state now{};
        midair_state(_scene, &now);
        all.field = ofC.field();
        all.state = now.state;
        all.sent = now.sent;
        std::array<midair_touch, 64> touches{};
        std::size_t count = 0;
        EXPECT_EQ(midair_touches(_scene, touches.data(), touches.size(), &count), MIDAIR_OK);
        for (std::size_t i = 0; i < count; ++i)
            if (touches[i].touching)
                all.touches.push_back(fmt::format("{} {} {:.6g} m {:.6g} N",
                                                  touches[i].hand,
                                                  touches[i].finger,
                                                  touches[i].distance_m,
                                                  touches[i].force_N));
        std::vector<char> text(65536);
        midair_messages(_scene, text.data(), text.size(), nullptr);
        std::istringstream lines(text.data());
        for (std::string line; std::getline(lines, line);)
            all.messages.push_back(withoutNames(line));
        std::sort(all.touches.begin(), all.touches.end());
        return all;
    }

private:
    midair_array* _array = nullptr;
    midair_scene* _scene = nullptr;
    midair_object _box = 0;
    double _hand_m = 0.0;
};

#ifdef MIDAIR_PYTHON
/// A program in Python, which plays by lines that are written to it.
class PythonPlayer : public Player
{
public:
    PythonPlayer()
    {
        std::array<int, 2> to{};
        std::array<int, 2> from{};
        if (::pipe2(to.data(), O_CLOEXEC) != 0 || ::pipe2(from.data(), O_CLOEXEC) != 0) return;
        _child = ::fork();
        if (_child == 0)
        {
            ::dup2(to[0], STDIN_FILENO);
            ::dup2(from[1], STDOUT_FILENO);
            ::setenv("PYTHONPATH", MIDAIR_PYTHON_FOLDER, 1);
            ::setenv("PYTHONDONTWRITEBYTECODE", "1", 1);
            ::execl(MIDAIR_PYTHON,
                    MIDAIR_PYTHON,
                    MIDAIR_ROOT "/tests/plugin/engine/one_engine.py",
                    nullptr);
            ::_exit(127);
        }
        ::close(to[0]);
        ::close(from[1]);
        _to = ::fdopen(to[1], "w");
        _from = ::fdopen(from[0], "r");
    }
    ~PythonPlayer() override
    {
        std::fclose(_to); // which ends it
        std::fclose(_from);
        ::waitpid(_child, nullptr, 0);
    }
    PythonPlayer(const PythonPlayer&) = delete;
    PythonPlayer& operator=(const PythonPlayer&) = delete;

    void begin(const std::string& array) { tell("begin " + array); }
    void end() { tell("end"); }
    void set(const std::string& name, const std::string& value) override
    {
        tell("set " + name + "=" + value);
    }
    void setOfBox(const std::string& name, const std::string& value) override
    {
        tell("box " + name + "=" + value);
    }
    void move(double x_m) override { tell(fmt::format("move {}", x_m)); }
    void setHand(double z_m) override { tell(fmt::format("hand {}", z_m)); }
    void setPlate(double z_m) override { tell("plate " + plateAt(z_m)); }
    void setMuted(bool isMuted) override { tell(isMuted ? "mute 1" : "mute 0"); }
    void setLost(bool isLost) override { tell(isLost ? "lost 1" : "lost 0"); }
    void frame(double time_s) override { tell(fmt::format("frame {}", time_s)); }
    bool isSettled() override { return !_isWaiting; }
    Seen seen() override
    {
        tell("seen");
        std::fflush(_to);
        Seen all;
        char* line = nullptr;
        std::size_t room = 0;
        for (ssize_t size = 0; (size = ::getline(&line, &room, _from)) > 0;)
        {
            const std::string text(line, static_cast<std::size_t>(size - 1));
            if (text == ".") break;
            take(text.substr(0, text.find(' ')), text.substr(text.find(' ') + 1), all);
        }
        std::free(line);
        std::sort(all.touches.begin(), all.touches.end());
        return all;
    }

private:
    void tell(const std::string& line)
    {
        std::fputs((line + "\n").c_str(), _to);
        std::fflush(_to);
    }
    void take(const std::string& what, const std::string& text, Seen& all)
    {
        if (what == "waiting") _isWaiting = text != "0";
        if (what == "state") all.state = std::stoi(text);
        if (what == "sent") all.sent = std::stoull(text);
        if (what == "touch") all.touches.push_back(text);
        if (what == "told") all.messages.push_back(withoutNames(text));
        if (what != "field") return;
        for (std::size_t i = 0; i + 1 < text.size(); i += 2)
            all.field.push_back(
                static_cast<std::uint8_t>(std::stoi(text.substr(i, 2), nullptr, 16)));
    }

    pid_t _child = -1;
    std::FILE* _to = nullptr;
    std::FILE* _from = nullptr;
    bool _isWaiting = true;
};
#endif

constexpr int kSeedsAtOnce = 10;

/// All players, and the array's file, which they read.
class OneEngine : public testing::TestWithParam<int>
{
protected:
    OneEngine()
    {
        registerRecorders();
        _file = (std::filesystem::temp_directory_path() /
                 fmt::format("one-engine-{}-{}.json", ::getpid(), GetParam()))
                    .string();
    }
    ~OneEngine() override { std::filesystem::remove(_file); }

    /// Begins anew, with the calls that \a seed gives.
    void begin(int seed)
    {
        _random.seed(static_cast<std::uint32_t>(seed));
        ofKit.setLost(false);
        ofC.setLost(false);
        _isLost = _isRough = _areEdges = false;
        _sent.clear();
        _awaited.clear();
        write(-1);
        _awaited.clear();
        _players.clear();
        _players.push_back(std::make_unique<KitPlayer>(_file));
        _players.push_back(std::make_unique<CPlayer>(_file));
#ifdef MIDAIR_PYTHON
        _python.begin(_file);
#endif
        _time_s = 0.0;
    }
    void end()
    {
        _players.clear();
#ifdef MIDAIR_PYTHON
        _python.end();
#endif
    }
    std::vector<Player*> players()
    {
        std::vector<Player*> all;
        for (const auto& player : _players)
            all.push_back(player.get());
#ifdef MIDAIR_PYTHON
        all.push_back(&_python);
#endif
        return all;
    }

    template<typename T>
    const T& oneOf(const std::vector<T>& all)
    {
        return all[std::uniform_int_distribution<std::size_t>(0, all.size() - 1)(_random)];
    }

    /// Writes the array's file, with the transducer \a dead out of use; -1: none.
    void write(int dead)
    {
        midair::haptics::TransducerArray array = midair::haptics::TransducerArray::load("board");
        array.name = fmt::format("version {}", ++_versions);
        if (dead >= 0) array.setDead({dead});
        std::ofstream(_file) << array.toJson();
        _awaited = "array \"" + array.name + "\" has changed";
        _dead = dead;
    }

    template<typename Call>
    void each(const Call& call)
    {
        for (Player* player : players())
            call(*player);
    }
    /// Makes all do something, and returns what it was.
    std::string step();
    std::string recover();
    static bool hasTold(const Seen& seen, const std::string& what)
    {
        return std::any_of(seen.messages.begin(),
                           seen.messages.end(),
                           [&](const std::string& message)
                           { return message.find(what) != std::string::npos; });
    }
    /// Whether the array's file was read again since it was written last.
    bool hasRead(const Seen& seen) const
    {
        return _awaited.empty() || hasTold(seen, _awaited);
    }
    /// Fields that the player \a i has sent since the last step.
    std::uint64_t sentNow(const std::vector<Seen>& seen, std::size_t i) const
    {
        return seen[i].sent - (_sent.empty() ? 0 : _sent[i]);
    }
    /// Runs a frame of each.
    void frames()
    {
        _time_s += 0.01;
        for (Player* player : players())
            player->frame(_time_s);
        letPass(3e-3); // what a frame has begun comes to its end before the next step
    }
    /// Runs frames until all have come to rest and show the same.
    void expectSame(const std::string& what)
    {
        std::vector<Seen> seen;
        int same = 0;
        int apart = 0;
        eventually(
            [&]
            {
                seen.clear();
                frames();
                bool isRest = true;
                for (Player* player : players())
                    seen.push_back(player->seen());
                // A change and the frame after it are solved at once or one after the other, as
                // threads wake up; the fields that follow then begin from others.
                bool isApart = false;
                for (std::size_t i = 1; i < seen.size(); ++i)
                    isApart = isApart || sentNow(seen, i) != sentNow(seen, 0);
                for (std::size_t i = 0; i < seen.size(); ++i)
                {
                    const Seen last = seen[i];
                    if (_isRough || isApart) seen[i] = roughly(last);
                    const bool isLost = last.state == static_cast<int>(ArrayState::LOST);
                    // The state is that of the moment; a pipeline looks for losses and tells them.
                    isRest = isRest && players()[i]->isSettled() && isLost == _isLost &&
                             (!isLost || hasTold(last, "device: lost")) &&
                             last.state != static_cast<int>(ArrayState::OPENING) && hasRead(last) &&
                             seen[i] == seen.front();
                }
                same = isRest ? same + 1 : 0;
                apart = isRest && isApart ? apart + 1 : 0;
                // Edges at rest are solved once more, as one outline: that comes to its end too.
                return same - apart >= (_areEdges ? 20 : 2) || apart == 50;
            });
        _sent.resize(seen.size());
        for (std::size_t i = 0; i < seen.size(); ++i)
            _sent[i] = seen[i].sent;
        if (apart > 0 && !_isRough) ++_apart;
        _isRough = _isRough || apart > 0;
        for (std::size_t i = 1; i < seen.size(); ++i)
            EXPECT_EQ(seen[0], seen[i]) << "player " << i << " after " << what;
        EXPECT_EQ(seen[0].state == static_cast<int>(ArrayState::LOST), _isLost) << what;
        EXPECT_TRUE(_isRough || hasRead(seen[0])) << what;
    }

    std::mt19937 _random;
    std::string _file;
    std::vector<std::unique_ptr<Player>> _players;
#ifdef MIDAIR_PYTHON
    PythonPlayer _python;
#endif
    double _time_s = 0.0;
    bool _isLost = false;
    bool _isRough = false; ///< only what roughly() leaves has to be the same
    bool _areEdges = false;
    std::vector<std::uint64_t> _sent; ///< of each player, as of the last step
    int _apart = 0; ///< steps after which players had sent different numbers of fields
    int _dead = -1;
    int _versions = 0;    ///< of the array's file
    std::string _awaited; ///< what is told of the array's file; empty: it wasn't written again
};

using Setting = std::pair<std::string, std::string>;
const std::vector<Setting> kSettings = {
    {"loudness", "0.5"},    {"loudness", "1"},        {"maxPressure", "300"},
    {"maxPressure", "0"},   {"maxAmplitude", "0.4"},  {"maxAmplitude", "1"},
    {"maxPoints", "5"},     {"maxPoints", "0"},       {"temperature", "25"},
    {"earLimit", "100"},    {"earLimit", "none"},     {"reach", "0.03"},
    {"reach", "0"},         {"shadows", "true"},      {"shadows", "false"},
    {"phaseOnly", "false"}, {"phaseOnly", "true"},    {"dead", "3, 7"},
    {"dead", ""},           {"earPoints", "0 0 0.5"}, {"solver", "gs-pat"},
    {"solver", ""}};
const std::vector<Setting> kOfBox = {{"pressure", "500 Pa"},
                                     {"pressure", "1 relative"},
                                     {"spacing", "0.01"},
                                     {"sampling", "edges"},
                                     {"sampling", "surface"},
                                     {"enabled", "false"},
                                     {"enabled", "true"}};

/// Ends what was lost, and then makes all begin another field; empty: nothing is to be ended.
std::string OneEngine::recover()
{
    if (_isLost)
    {
        _isLost = false;
        each([&](Player& player) { player.setLost(false); });
        return "back";
    }
    if (_isRough) // another array begins without the last field
    {
        _isRough = false;
        const std::string dead = oneOf<std::string>({"5", "6, 9"});
        each([&](Player& player) { player.set("dead", dead); });
        return "dead=" + dead;
    }
    return {};
}

std::string OneEngine::step()
{
    if (std::string done = recover(); !done.empty()) return done;
    switch (std::uniform_int_distribution<int>(0, 11)(_random))
    {
    case 0:
    case 1:
    case 2:
    case 3:
    {
        const Setting& one = oneOf(kSettings);
        each([&](Player& player) { player.set(one.first, one.second); });
        return one.first + "=" + one.second;
    }
    case 4:
    case 5:
    {
        const Setting& one = oneOf(kOfBox);
        if (one.first == "sampling") _areEdges = one.second == "edges";
        each([&](Player& player) { player.setOfBox(one.first, one.second); });
        return "box " + one.first + "=" + one.second;
    }
    case 6:
    case 7:
    {
        const double x_m = oneOf<double>({-0.02, -0.01, 0.0, 0.015});
        each([&](Player& player) { player.move(x_m); });
        return fmt::format("move {}", x_m);
    }
    case 8:
    {
        const double z_m = oneOf<double>({0.0, 0.16, 0.172, 0.178, 0.25});
        each([&](Player& player) { player.setHand(z_m); });
        return fmt::format("hand {}", z_m);
    }
    case 9:
    {
        const bool isMuted = oneOf<int>({0, 1}) == 1;
        each([&](Player& player) { player.setMuted(isMuted); });
        return isMuted ? "mute" : "unmute";
    }
    case 10:
    {
        _isLost = _isRough = true;
        each([&](Player& player) { player.setLost(true); });
        return "lost";
    }
    default:
        write(_dead == 1 ? -1 : 1);
        return "array file";
    }
}

} // namespace

TEST_P(OneEngine, PlaysTheSameForAll)
{
    for (int seed = GetParam(); seed < GetParam() + kSeedsAtOnce && !HasFailure(); ++seed)
    {
        begin(seed);
        std::string done = fmt::format("seed {}: ", seed);
        expectSame(done);
        for (int i = 0; i < 6 && !HasFailure(); ++i)
        {
            done += step() + "; ";
            expectSame(done);
        }
        end();
    }
    EXPECT_LE(_apart, kSeedsAtOnce) << "of " << 7 * kSeedsAtOnce << " steps";
}

INSTANTIATE_TEST_SUITE_P(Random, OneEngine, testing::Range(0, 200, kSeedsAtOnce));

/// The same with a reflector over the box, which changes their fields and moves.
class OneEngineBesideAPlate : public OneEngine
{
protected:
    /// Runs frames until each plays another field than \a last.
    bool changesAll(const std::vector<std::uint8_t>& last)
    {
        return eventually(
            [&]
            {
                frames();
                bool isOther = true;
                each([&](auto& player) { isOther = isOther && player.seen().field != last; });
                return isOther;
            });
    }
};

TEST_P(OneEngineBesideAPlate, PlaysTheSameForAll)
{
    begin(GetParam());
    // Only what is solved: a walk at rest sends as many fields as the clock lets it.
    each([](auto& player) { player.set("even", "0"); });
    expectSame("nothing");
    int exact = 0;
    std::vector<std::uint8_t> last = players().front()->seen().field;
    for (const double z_m : {0.3125, 0.34375, 0.0, 0.3125})
    {
        each([&](auto& player) { player.setPlate(z_m); });
        const std::string what = fmt::format("plate {}", z_m);
        EXPECT_TRUE(changesAll(last)) << what << " changes nothing";
        expectSame(what);
        exact += _isRough ? 0 : 1;
        each([&](auto& player) { player.move(0.01 + 0.01 * z_m); });
        expectSame(fmt::format("a move beside plate {}", z_m));
        if (const std::string done = recover(); !done.empty()) expectSame(done);
        last = players().front()->seen().field;
    }
    EXPECT_GT(exact, 0) << "none was compared byte by byte";
    end();
}

INSTANTIATE_TEST_SUITE_P(One, OneEngineBesideAPlate, testing::Values(1000));
