/// A piano in the array: each key vibrates under a finger with its own frequency.

#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/Looks.h"
#include "samples/shared/views/ShownObject.h"

#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osgText/Text>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace
{

using namespace midair::samples;

constexpr int kKeys = 8;
constexpr std::array<const char*, kKeys> kNames = {"C", "D", "E", "F", "G", "A", "B", "c"};
/// Semitones above the lowest key: a major scale.
constexpr std::array<int, kKeys> kSemitones = {0, 2, 4, 5, 7, 9, 11, 12};
constexpr double kWidth_m = 0.0185;
constexpr double kGap_m = 0.0015;
constexpr double kLength_m = 0.075;
constexpr double kThickness_m = 0.008;
constexpr double kTop_m = -0.012; ///< of a released key
constexpr double kTravel_m = 0.003;
constexpr double kTravelTime_s = 0.06;
constexpr double kPressure_Pa = 3000.0;

double middleOf(int key)
{
    return (key - 0.5 * (kKeys - 1)) * (kWidth_m + kGap_m);
}

struct Key
{
    osg::ref_ptr<osgMidair::HapticSurface> surface;
    osg::ref_ptr<osg::MatrixTransform> moved;
    double frequency_Hz = 0.0;
    int fingers = 0;   ///< touching it now; it vibrates while any does
    double down = 0.0; ///< 0 .. 1
    std::uint64_t touches = 0;
    double longest_s = 0.0; ///< longest vibration
    double force_N = 0.0;   ///< largest force
    double since_s = 0.0;   ///< start of the vibration
};

class Piano : public Installation
{
public:
    InstallationTitle title() const override
    {
        return {"piano",
                "Eight keys that vibrate under the finger, each with its own frequency.",
                "Touch the keys: each vibrates with its own note"};
    }

    void addOptions(CLI::App& app) override
    {
        app.add_option("--lowest", _lowest_Hz, "Frequency of the lowest key, Hz")
            ->check(CLI::Range(20.0, 250.0))
            ->capture_default_str();
    }

    void arrange(osgMidair::HapticSettings& settings) override
    {
        settings.prediction = osgMidair::HapticSettings::KALMAN;
    }

    void build(Stage& stage) override
    {
        for (int i = 0; i < kKeys; ++i)
            add(stage, i);
    }

    Viewpoint viewpoint() const override
    {
        return {{0.24, -0.42, 0.42}, {0.0, -0.012, -0.010}, osg::Z_AXIS, 13.5};
    }

    // Plays the scale upwards with one finger, then rests.
    bool demonstrate(double time_s, std::vector<osgMidair::Hand>& hands) override
    {
        constexpr double kNote_s = 0.6;
        constexpr double kComes_s = 1.0;
        constexpr double kRest_s = 5.0;
        constexpr double kAbove_m = 0.028;
        const double t = std::fmod(time_s, kComes_s + kKeys * kNote_s + kRest_s) - kComes_s;
        if (t < 0.0 || t > kKeys * kNote_s) return false;
        const int key = std::min(kKeys - 1, static_cast<int>(t / kNote_s));
        const double in = t - key * kNote_s;
        const double next = std::min(kKeys - 1, key + 1);
        const double x =
            middleOf(key) + (next - key) * (kWidth_m + kGap_m) * eased(in, 0.45, kNote_s);
        const double pressed = eased(in, 0.05, 0.15) - eased(in, 0.4, 0.5);
        // The finger pad is 7 mm below the centre of the tip and goes 2 mm into the key.
        const double low = kTop_m - kTravel_m + 0.005;
        hands.push_back(pointingHand({x, -0.012, low + kAbove_m * (1.0 - pressed)}, 0.35));
        return true;
    }

    void update(const Moment& now) override
    {
        _time_s = now.time_s;
        for (Key& key : _keys)
        {
            const double goal = key.fingers > 0 ? 1.0 : 0.0;
            const double step = now.step_s / kTravelTime_s;
            key.down = std::clamp(goal, key.down - step, key.down + step);
            key.moved->setMatrix(osg::Matrix::translate(0.0, 0.0, -kTravel_m * key.down));
            if (key.fingers > 0) key.longest_s = std::max(key.longest_s, now.time_s - key.since_s);
        }
    }

    void touched(const osgMidair::Touch& touch) override
    {
        Key* key = find(touch.node);
        if (!key) return;
        ++key->touches;
        if (++key->fingers == 1)
        {
            key->since_s = _time_s;
            paint(*key->surface->getChild(0),
                  kShownColors[static_cast<std::size_t>(key - _keys.data()) % kShownColors.size()]);
        }
        stroked(touch);
    }
    void stroked(const osgMidair::Touch& touch) override
    {
        if (Key* key = find(touch.node)) key->force_N = std::max(key->force_N, touch.force);
    }
    void left(const osgMidair::Touch& touch) override
    {
        Key* key = find(touch.node);
        if (key && --key->fingers == 0) paint(*key->surface->getChild(0), kIvory);
    }

    std::string caption() const override
    {
        std::string notes;
        for (std::size_t i = 0; i < _keys.size(); ++i)
            if (_keys[i].fingers > 0)
                notes += fmt::format("{}{}   {:.0f} Hz",
                                     notes.empty() ? "" : "      ",
                                     kNames[i],
                                     _keys[i].frequency_Hz);
        return notes;
    }

    void report(nlohmann::ordered_json& figures) const override
    {
        for (std::size_t i = 0; i < _keys.size(); ++i)
            figures["keys"].push_back({{"name", kNames[i]},
                                       {"frequency_Hz", _keys[i].frequency_Hz},
                                       {"touches", _keys[i].touches},
                                       {"longest_s", _keys[i].longest_s},
                                       {"largestForce_mN", 1e3 * _keys[i].force_N}});
    }

private:
    void add(Stage& stage, int number)
    {
        Key& key = _keys[static_cast<std::size_t>(number)];
        key.frequency_Hz =
            _lowest_Hz * std::pow(2.0, kSemitones[static_cast<std::size_t>(number)] / 12.0);
        key.surface = new osgMidair::HapticSurface;
        key.surface->setName(std::string("key ") + kNames[static_cast<std::size_t>(number)]);
        key.surface->setTouchEvents(true);
        key.surface->setSensation(
            fmt::format("point-am?radius=0mm&modulation={:.3f}Hz", key.frequency_Hz));
        key.surface->setAttach("surface");
        key.surface->setTrigger(osgMidair::HapticProperty::TOUCH_STAY);
        key.surface->setPressureUnit(osgMidair::HapticProperty::PASCAL);
        key.surface->setPressure(kPressure_Pa);
        key.surface->addChild(
            solid(new osg::Box({0.0F, 0.0F, static_cast<float>(-0.5 * kThickness_m)},
                               static_cast<float>(kWidth_m),
                               static_cast<float>(kLength_m),
                               static_cast<float>(kThickness_m)),
                  kIvory));
        key.moved = new osg::MatrixTransform;
        key.moved->setDataVariance(osg::Object::DYNAMIC);
        key.moved->addChild(key.surface);
        key.moved->addChild(nameOf(number));
        const osg::ref_ptr<osg::MatrixTransform> placed =
            new osg::MatrixTransform(osg::Matrix::translate(middleOf(number), 0.0, kTop_m));
        placed->addChild(key.moved);
        stage.haptics.addChild(placed);
    }

    static osg::ref_ptr<osg::Node> nameOf(int number)
    {
        osg::ref_ptr<osgText::Text> text = new osgText::Text;
        text->setFont(labelFont());
        text->setCharacterSize(0.010F);
        text->setText(kNames[static_cast<std::size_t>(number)]);
        text->setAlignment(osgText::TextBase::CENTER_CENTER);
        text->setPosition({0.0F, static_cast<float>(-0.38 * kLength_m), 0.0005F});
        text->setColor({0.15F, 0.17F, 0.2F, 1.0F});
        text->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
        return text;
    }

    Key* find(const osg::Node* surface)
    {
        for (Key& key : _keys)
            if (key.surface == surface) return &key;
        return nullptr;
    }

    inline static const osg::Vec4 kIvory{0.90F, 0.88F, 0.82F, 1.0F};

    double _lowest_Hz = 110.0;
    double _time_s = 0.0;
    std::array<Key, kKeys> _keys;
};

} // namespace

int main(int argc, char** argv)
{
    Piano piano;
    return runInstallation(piano, argc, argv);
}
