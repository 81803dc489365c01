#include "engine/model/contact_memory.h"

template class std::vector<lithe::ContactTrace>;
