// midair-paper-scenes: plays the paper's scenes one after the other.

#include "samples/experiments/paper/LineExperiment.h"
#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/Looks.h"
#include "samples/shared/views/ShownObject.h"

#include <osgMidair/HapticPoints>

#include <osg/Shape>
#include <osg/Switch>
#include <osgGA/GUIEventAdapter>

#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace
{

using namespace midair::samples;

/// Shows each scene for a while in turn, until somebody chooses one.
class PaperInstallation : public Installation
{
public:
    InstallationTitle title() const override
    {
        return {"paper-scenes",
                "The scenes of Inoue, Makino and Shinoda's paper, one after the other. The keys 1 "
                "to 6 choose one, the space bar continues.",
                "Reach into the array: what you see can be felt"};
    }

    void addOptions(CLI::App& app) override
    {
        app.add_option("--each", _each_s, "How long each scene is shown")
            ->check(CLI::Range(0.1, 3600.0))
            ->capture_default_str()
            ->type_name("S");
        app.add_option("--pressure", _pressure_Pa, "Peak pressure at every point, Pa")
            ->check(CLI::Range(1.0, 1e5))
            ->capture_default_str();
        app.add_option("--scene", _held, "Number of the scene to show; 0: all in turn")
            ->check(CLI::Range(0, 6))
            ->capture_default_str();
    }

    void build(Stage& stage) override
    {
        _scenes = paperScenes(sampleFile("models/star.obj"));
        _points = new osgMidair::HapticPoints;
        _points->setName("points");
        _points->setPressureUnit(osgMidair::HapticProperty::PASCAL);
        _points->setPressure(_pressure_Pa);
        stage.haptics.addChild(_points);
        _seen = new osg::Switch;
        for (const PaperScene& scene : _scenes)
            _seen->addChild(seen(scene), false);
        stage.lit.addChild(_seen);
        stage.lit.addChild(glassBox(osg::Vec3d(), osg::Vec3d(0.13, 0.05, 0.13)));
        show(_held > 0 ? static_cast<std::size_t>(_held - 1) : 0);
    }

    Viewpoint viewpoint() const override
    {
        Viewpoint from;
        from.eye = osg::Vec3d(0.05, -0.50, 0.06);
        from.centre = osg::Vec3d(0.0, 0.0, 0.004);
        return from;
    }

    std::vector<std::string> overlays() const override { return {"points", "slice", "hands"}; }

    void update(const Moment& now) override
    {
        _time_s = now.time_s;
        if (_shown < _fields.size() && now.statistics.points == _scenes[_shown].points.cols())
            _fields[_shown] = {now.statistics.level_Pa, now.statistics.rms};
        if (_held > 0 || now.time_s - _since_s < _each_s) return;
        _since_s = now.time_s;
        show((_shown + 1) % _scenes.size());
    }

    void pressed(int key) override
    {
        if (key == osgGA::GUIEventAdapter::KEY_Space)
        {
            _held = 0;
            _since_s = _time_s;
        }
        if (key < '1' || key >= '1' + static_cast<int>(_scenes.size())) return;
        _held = key - '0';
        show(static_cast<std::size_t>(_held - 1));
    }

    /// Moves a fingertip along the object's lower edge.
    bool demonstrate(double time_s, std::vector<osgMidair::Hand>& hands) override
    {
        const double x = 0.02 * std::sin(1.5 * time_s);
        hands.push_back(pointingHand(osg::Vec3d(x, 0.004, -0.018), 0.35));
        return true;
    }

    std::string caption() const override
    {
        const PaperScene& scene = _scenes[_shown];
        return fmt::format("{}. {}", _shown + 1, scene.caption);
    }

    void report(nlohmann::ordered_json& figures) const override
    {
        for (std::size_t k = 0; k < _scenes.size(); ++k)
        {
            if (_fields[k].level_Pa <= 0.0) continue;
            nlohmann::ordered_json& own = figures[_scenes[k].name];
            own["points"] = _scenes[k].points.cols();
            own["level_Pa"] = _fields[k].level_Pa;
            own["rms"] = _fields[k].rms;
        }
    }

private:
    struct Field
    {
        double level_Pa = 0.0, rms = 0.0;
    };

    /// Returns a ball for each control point.
    static osg::ref_ptr<osg::Node> seen(const PaperScene& scene)
    {
        const osg::ref_ptr<osg::Group> balls = new osg::Group;
        for (Eigen::Index k = 0; k < scene.points.cols(); ++k)
        {
            const osg::Vec3 at(static_cast<float>(scene.points(0, k)),
                               static_cast<float>(scene.points(1, k)),
                               static_cast<float>(scene.points(2, k)));
            balls->addChild(solid(new osg::Sphere(at, 0.0015F), kShownColors[1]));
        }
        return balls;
    }

    void show(std::size_t number)
    {
        _shown = number;
        std::vector<osg::Vec3d> places;
        const Eigen::Matrix3Xd& points = _scenes[number].points;
        for (Eigen::Index k = 0; k < points.cols(); ++k)
            places.emplace_back(points(0, k), points(1, k), points(2, k));
        _points->setPoints(places);
        _seen->setSingleChildOn(static_cast<unsigned int>(number));
        _fields.resize(_scenes.size());
    }

    std::vector<PaperScene> _scenes;
    std::vector<Field> _fields; ///< newest figures of each scene
    osg::ref_ptr<osgMidair::HapticPoints> _points;
    osg::ref_ptr<osg::Switch> _seen;
    std::size_t _shown = 0;
    int _held = 0; ///< number of the chosen scene; 0: none
    double _each_s = 12.0;
    double _pressure_Pa = 2900.0; ///< below the cap that the shell sets for visitors
    double _since_s = 0.0;
    double _time_s = 0.0;
};

} // namespace

int main(int argc, char** argv)
{
    PaperInstallation installation;
    return runInstallation(installation, argc, argv);
}
