#pragma once

#include <osg/Node>
#include <osgDB/Options>
#include <osgDB/ReaderWriter>

#include <string>
#include <vector>

namespace midair::samples
{

/// Reads a file by osgMidair::readModel(), or by the registry's callback, if there is one.
osgDB::ReaderWriter::ReadResult readSafely(const std::string& file, const osgDB::Options* options);

/// Reads the files that PagedLODs and ProxyNodes at and below \a root name, level by level: a
/// viewer's pager does it as it draws, and here nothing is drawn. Reads at most kMostPagedFiles.
/// Returns sentences about what is not read.
std::vector<std::string> readPagedFiles(osg::Node& root);
constexpr int kMostPagedFiles = 256;

} // namespace midair::samples
