#pragma once

#include "tests/plugin/KitTest.h"

#include <osgMidair/FieldSliceOverlay>
#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticPoints>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace osgMidair::test
{

inline HapticProperty unusualProperty()
{
    HapticProperty p;
    p.enabled = false;
    p.pressure = 812.5;
    p.pressureUnit = HapticProperty::PASCAL;
    p.spacing = 0.0125;
    p.sampling = HapticProperty::EDGES;
    p.side = HapticProperty::BACK;
    p.priority = -7;
    p.modulationFrequency = 200.5;
    p.modulationDepth = 0.25;
    p.intensity = HapticProperty::TEXTURE;
    p.touchEvents = true;
    p.intensityChannel = HapticProperty::BLUE;
    p.intensityLow = 0.125;
    p.intensityHigh = 0.875;
    p.render = HapticProperty::AUTO;
    p.material = "cloth";
    p.stiffness = 37.5;
    p.contactForce = 0.015625;
    p.softness = 0.25;
    p.roughness = 0.375;
    p.texturePeriod = 0.0078125;
    p.lowVibration = 0.125;
    p.highVibration = 0.0625;
    p.sensation = "circle?radius=12mm";
    p.attach = "hand:index_tip";
    p.trigger = HapticProperty::TOUCH_STAY;
    p.sensationSpeed = 0.75;
    p.seed = 77;
    p.parameters = "radius=8; frequency=60";
    p.plays = 3;
    return p;
}

inline HapticSettings unusualSettings()
{
    HapticSettings s;
    s.enabled = false;
    s.array = "my arrays/board \"two\".json";
    s.device = "record:out.bin";
    s.calibration = osg::Matrixd::rotate(0.5, osg::Vec3d(1.0, 0.0, 0.0)) *
                    osg::Matrixd::translate(0.125, -0.25, 1.0 / 3.0);
    s.metresPerUnit = 0.001;
    s.temperature = 14.5;
    s.humidity = 0.25;
    s.airPressure = 95000.0;
    s.solver = "gs";
    s.maxIterations = 17;
    s.rmsTolerance = 0.0078125;
    s.deadline_ms = 2.5;
    s.lambda = 0.5;
    s.loudness = 0.75;
    s.phaseOnly = false;
    s.threads = 2;
    s.motionTolerance = 0.0625;
    s.maxPoints = 321;
    s.hands = "recorded:hand.csv?loop";
    s.heads = "fixed 0 -0.25 0.5";
    s.reach = 0.0625;
    s.shadows = true;
    s.maxPressure = 1250.5;
    s.maxAmplitude = 0.375;
    s.cycle = 8;
    s.cycleSteps = 3;
    s.subsets = 2;
    s.fieldRate = 500.0;
    s.denseOutlines = false;
    s.monitorInterval = 0.25;
    s.even = 40;
    s.earLimit = 117.5;
    s.earPoints = "0 0 0.5; -0.25 0.125 0.5";
    s.earCamera = true;
    s.prediction = HapticSettings::KALMAN;
    s.trackerDelay = 0.03125;
    s.render = HapticSettings::CONTACT;
    s.contactRate = 7.5;
    s.contactStep = 0.00025;
    s.contactFoci = 3;
    s.contactMask = true;
    s.trackerError = 0.0078125;
    s.dead = "17, 400-410";
    s.weak = "3:0.5";
    s.temperatureSource = "room/thermometer.txt";
    s.contactHold = 0.25;
    s.extrapolate = false;
    s.displayLatency = 0.0625;
    s.headError = 0.0078125;
    s.arrayError = 0.00390625;
    s.airError = 1.5;
    s.feelThreshold = 0.00390625;
    return s;
}

inline const std::vector<osg::Vec3d> kUnusualPoints = {{0.0, 0.125, -0.25}, {0.5, 0.0, 0.03125}};
inline const std::vector<double> kUnusualPressures = {0.5, 2.0};

inline osg::ref_ptr<HapticScene> unusualScene()
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    scene->setSettings(unusualSettings());
    scene->setName("unusual");
    osg::ref_ptr<HapticSurface> surface = new HapticSurface(BoxScene::box().get());
    surface->setProperty(unusualProperty());
    scene->addChild(surface);
    osg::ref_ptr<HapticSurface> ordinary = new HapticSurface;
    scene->addChild(ordinary);
    osg::ref_ptr<HapticPoints> points = new HapticPoints;
    points->setPoints(kUnusualPoints, kUnusualPressures);
    points->setPriority(4);
    scene->addChild(points);
    osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
    overlays->setShown("array", false);
    overlays->setShown("ears", true);
    overlays->setShown("axes", true);
    EXPECT_TRUE(overlays->setNumber("sliceRadius", 0.0625));
    scene->addChild(overlays);
    return scene;
}

/// Text formats write six digits.
inline void expectNear(double a, double b)
{
    EXPECT_NEAR(a, b, 2e-6 * std::max(1.0, std::abs(b)));
}

inline void expectUnusual(const HapticProperty& p)
{
    const HapticProperty wanted = unusualProperty();
    EXPECT_EQ(p.enabled, wanted.enabled);
    expectNear(p.pressure, wanted.pressure);
    EXPECT_EQ(p.pressureUnit, wanted.pressureUnit);
    expectNear(p.spacing, wanted.spacing);
    EXPECT_EQ(p.sampling, wanted.sampling);
    EXPECT_EQ(p.side, wanted.side);
    EXPECT_EQ(p.priority, wanted.priority);
    expectNear(p.modulationFrequency, wanted.modulationFrequency);
    expectNear(p.modulationDepth, wanted.modulationDepth);
    EXPECT_EQ(p.intensity, wanted.intensity);
    EXPECT_EQ(p.touchEvents, wanted.touchEvents);
    EXPECT_EQ(p.intensityChannel, wanted.intensityChannel);
    expectNear(p.intensityLow, wanted.intensityLow);
    expectNear(p.intensityHigh, wanted.intensityHigh);
    EXPECT_EQ(p.render, wanted.render);
    EXPECT_EQ(p.material, wanted.material);
    expectNear(p.stiffness, wanted.stiffness);
    expectNear(p.contactForce, wanted.contactForce);
    expectNear(p.softness, wanted.softness);
    expectNear(p.roughness, wanted.roughness);
    expectNear(p.texturePeriod, wanted.texturePeriod);
    expectNear(p.lowVibration, wanted.lowVibration);
    expectNear(p.highVibration, wanted.highVibration);
    EXPECT_EQ(p.sensation, wanted.sensation);
    EXPECT_EQ(p.attach, wanted.attach);
    EXPECT_EQ(p.trigger, wanted.trigger);
    expectNear(p.sensationSpeed, wanted.sensationSpeed);
    EXPECT_EQ(p.seed, wanted.seed);
    EXPECT_EQ(p.parameters, wanted.parameters);
    EXPECT_EQ(p.plays, wanted.plays);
}

inline void expectUnusual(const HapticSettings& s)
{
    const HapticSettings wanted = unusualSettings();
    EXPECT_EQ(s.enabled, wanted.enabled);
    EXPECT_EQ(s.array, wanted.array);
    EXPECT_EQ(s.device, wanted.device);
    for (int i = 0; i < 16; ++i)
        expectNear(s.calibration.ptr()[i], wanted.calibration.ptr()[i]);
    expectNear(s.metresPerUnit, wanted.metresPerUnit);
    expectNear(s.temperature, wanted.temperature);
    expectNear(s.humidity, wanted.humidity);
    expectNear(s.airPressure, wanted.airPressure);
    EXPECT_EQ(s.solver, wanted.solver);
    EXPECT_EQ(s.maxIterations, wanted.maxIterations);
    expectNear(s.rmsTolerance, wanted.rmsTolerance);
    expectNear(s.deadline_ms, wanted.deadline_ms);
    expectNear(s.lambda, wanted.lambda);
    expectNear(s.loudness, wanted.loudness);
    EXPECT_EQ(s.phaseOnly, wanted.phaseOnly);
    EXPECT_EQ(s.threads, wanted.threads);
    expectNear(s.motionTolerance, wanted.motionTolerance);
    EXPECT_EQ(s.maxPoints, wanted.maxPoints);
    EXPECT_EQ(s.hands, wanted.hands);
    EXPECT_EQ(s.heads, wanted.heads);
    expectNear(s.reach, wanted.reach);
    EXPECT_EQ(s.shadows, wanted.shadows);
    expectNear(s.maxPressure, wanted.maxPressure);
    EXPECT_EQ(s.cycle, wanted.cycle);
    EXPECT_EQ(s.cycleSteps, wanted.cycleSteps);
    EXPECT_EQ(s.subsets, wanted.subsets);
    expectNear(s.fieldRate, wanted.fieldRate);
    EXPECT_EQ(s.denseOutlines, wanted.denseOutlines);
    expectNear(s.monitorInterval, wanted.monitorInterval);
    expectNear(s.maxAmplitude, wanted.maxAmplitude);
    EXPECT_EQ(s.even, wanted.even);
    expectNear(s.earLimit, wanted.earLimit);
    EXPECT_EQ(s.earPoints, wanted.earPoints);
    EXPECT_EQ(s.earCamera, wanted.earCamera);
    EXPECT_EQ(s.prediction, wanted.prediction);
    expectNear(s.trackerDelay, wanted.trackerDelay);
    EXPECT_EQ(s.render, wanted.render);
    expectNear(s.contactRate, wanted.contactRate);
    expectNear(s.contactStep, wanted.contactStep);
    EXPECT_EQ(s.contactFoci, wanted.contactFoci);
    EXPECT_EQ(s.contactHold, wanted.contactHold);
    EXPECT_EQ(s.extrapolate, wanted.extrapolate);
    expectNear(s.displayLatency, wanted.displayLatency);
    expectNear(s.headError, wanted.headError);
    expectNear(s.arrayError, wanted.arrayError);
    expectNear(s.airError, wanted.airError);
    expectNear(s.feelThreshold, wanted.feelThreshold);
    EXPECT_EQ(s.contactMask, wanted.contactMask);
    expectNear(s.trackerError, wanted.trackerError);
    EXPECT_EQ(s.dead, wanted.dead);
    EXPECT_EQ(s.weak, wanted.weak);
    EXPECT_EQ(s.temperatureSource, wanted.temperatureSource);
}

inline void expectUnusual(osg::Node* node)
{
    auto* scene = dynamic_cast<HapticScene*>(node);
    ASSERT_NE(scene, nullptr);
    EXPECT_EQ(scene->getName(), "unusual");
    expectUnusual(scene->getSettings());
    ASSERT_EQ(scene->getNumChildren(), 4u);
    auto* surface = dynamic_cast<HapticSurface*>(scene->getChild(0));
    ASSERT_NE(surface, nullptr);
    expectUnusual(surface->getProperty());
    EXPECT_EQ(surface->getNumChildren(), 1u);
    auto* ordinary = dynamic_cast<HapticSurface*>(scene->getChild(1));
    ASSERT_NE(ordinary, nullptr);
    EXPECT_TRUE(ordinary->getProperty() == HapticProperty());
    auto* points = dynamic_cast<HapticPoints*>(scene->getChild(2));
    ASSERT_NE(points, nullptr);
    EXPECT_EQ(points->getPoints(), kUnusualPoints);
    EXPECT_EQ(points->getPressures(), kUnusualPressures);
    EXPECT_EQ(points->getPriority(), 4);
    auto* overlays = dynamic_cast<HapticOverlays*>(scene->getChild(3));
    ASSERT_NE(overlays, nullptr);
    for (const OverlayDescription& one : HapticOverlays::describe())
        EXPECT_EQ(overlays->getOverlay(one.name)->isShown(), one.name != "Array") << one.name;
    EXPECT_EQ(overlays->get<FieldSliceOverlay>()->getRadius(), 0.0625);
}

} // namespace osgMidair::test
