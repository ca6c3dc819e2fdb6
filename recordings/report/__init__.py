"""A folder of recordings at a glance: one offline page of results, heat maps, waiting and failure cases."""
