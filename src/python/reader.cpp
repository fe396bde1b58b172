// The program that reads CAD files for an interpreter; see occ::ReaderProcess.
#include <patchwright/occ/guarded_read.h>

int main(int argc, char** argv) { return patchwright::occ::run_reader(argc, argv); }
